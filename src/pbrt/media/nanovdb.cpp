// Medium "nanovdb": densities, and temperatures, of a NanoVDB file.
//
//   "string filename"                       required     a .nvdb file
//   "string gridname"                       density      grid of densities; negative ones count as 0
//   "string temperaturename"                temperature  grid of temperatures, if there is one: black-body
//                                                        emission
//   "float Lescale"                         1            multiplies the emission
//   "float temperatureoffset"               0            T = (value - offset) scale [K]; "float
//                                                        temperaturecutoff" is an older name
//   "float temperaturescale"                1            see there
//   "spectrum sigma_a", "spectrum sigma_s"  1, 1         absorption and scattering coefficient of density 1
//                                                        [1 / unit of length in the world]
//   "string bulk"                           -            a file of "lacquer bulk" instead, in 1/mm, with its
//                                                        phase function
//   "float scale"                           1            multiplies both coefficients
//   "string phase"                          hg           and its parameters: see phases/
#include "pbrt/core/invertible.h"
#include "pbrt/media/medium_params.h"
#include "pbrt/media/nanovdb_file.h"
#include "pbrt/media/temperature_emission.h"

namespace lacquer {
namespace {

/// A grid in rendering space.
struct PlacedGrid {
    NanoVdbGrid grid;
    Transform indexFromRender;

    PlacedGrid(NanoVdbGrid g, const Transform& renderFromMedium)
        : grid(std::move(g)), indexFromRender((renderFromMedium * grid.mediumFromIndex).Inverse()) {}
};

class NanoVdb final : public Medium {
  public:
    explicit NanoVdb(const MediumArgs& args)
        : NanoVdb(args, NanoVdbFile(FileName(args.params), args.params.LocOf("filename"))) {}

    MediumProperties At(Point3 p, const SampledWavelengths& lambda) const override {
        const Point3 index = density_.indexFromRender.Point(p);
        if (!density_.grid.bounds.Contains(index)) return {};
        const float density = density_.grid.values.Lookup(index);
        if (density == 0) return {};
        MediumProperties properties{density * coefficients_.sigma_a.Sample(lambda),
                                    density * coefficients_.sigma_s.Sample(lambda), SampledSpectrum(0)};
        if (isEmissive_)
            properties.Le =
                LeScale_ *
                emission_.Le(temperature_->grid.values.Lookup(temperature_->indexFromRender.Point(p)),
                             lambda);
        return properties;
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths& lambda) const override {
        return {majorants_, density_.indexFromRender.Ray(ray), tMax,
                coefficients_.sigma_a.Sample(lambda) + coefficients_.sigma_s.Sample(lambda)};
    }
    bool IsEmissive() const override { return isEmissive_; }
    size_t MemoryBytes() const override {
        return density_.grid.values.MemoryBytes() +
               (temperature_ ? temperature_->grid.values.MemoryBytes() : 0);
    }

  private:
    NanoVdb(const MediumArgs& args, const NanoVdbFile& file)
        : Medium(ReadMediumPhase(args)),
          density_(file.Read(args.params.GetString("gridname", "density"), true), args.renderFromMedium),
          temperature_(ReadTemperature(args, file)),
          coefficients_(
              ReadCoefficients(args.params, density_.grid.values.Maximum(), "filename", GetPhaseModel())),
          emission_(args.params),
          LeScale_(ReadNonNegative(args.params, "Lescale", 1)),
          isEmissive_(temperature_ && LeScale_ > 0),
          majorants_(Bounds()) {}

    static std::string FileName(const Params& params) {
        if (!params.GetOptionalString("filename"))
            params.Fail("filename", "a medium \"nanovdb\" needs \"string filename\", a .nvdb file");
        return params.PathOf("filename");
    }
    /// Nothing if the file has no temperatures, unless the scene asks for them by name.
    static std::optional<PlacedGrid> ReadTemperature(const MediumArgs& args, const NanoVdbFile& file) {
        const std::optional<std::string> given = args.params.GetOptionalString("temperaturename");
        const std::string name = given.value_or("temperature");
        const std::vector<std::string> names = file.Names();
        if (!given && std::find(names.begin(), names.end(), name) == names.end()) return std::nullopt;
        return PlacedGrid(file.Read(name, false), args.renderFromMedium);
    }
    /// Cells of about a mean free path where the medium is densest, and large enough for few steps.
    MajorantGrid Bounds() const {
        const float sigma = coefficients_.sigma_a.MaxValue() + coefficients_.sigma_s.MaxValue();
        const Vec3 size = density_.grid.bounds.Diagonal();
        float longest = 0;
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 edge(0);
            edge[axis] = size[axis];
            longest = std::max(longest, Length(density_.indexFromRender.InverseVector(edge)));
        }
        const float meanFreePaths = sigma * density_.grid.values.Maximum() * longest;
        return BoundBlocks(density_.grid.values, int(std::ceil(std::clamp(meanFreePaths, 16.f, 128.f))));
    }

    PlacedGrid density_;
    std::optional<PlacedGrid> temperature_;
    Coefficients coefficients_;
    TemperatureEmission emission_;
    float LeScale_;
    bool isEmissive_;
    MajorantGrid majorants_;
};

std::unique_ptr<Medium> Create(const MediumArgs& args) {
    RequireInvertible(args.params, args.renderFromMedium);
    return std::make_unique<NanoVdb>(args);
}

}  // namespace

LACQUER_REGISTER(MediumKind, "nanovdb", Create);

}  // namespace lacquer
