// Medium "rgbgrid": colours on a regular grid of voxels.
//
//   "rgb sigma_a" [], "rgb sigma_s" []        1, 1              one value for each voxel, x fastest [1 / unit
//                                                               of length in the world]; at least one of the
//                                                               two
//   "rgb Le" []                               0                 emitted radiance; needs sigma_a
//   "float Lescale"                           1                 multiplies Le
//   "float scale"                             1                 multiplies both coefficients
//   "string phase"                            hg                and its parameters: see phases/
//   "integer nx", "integer ny", "integer nz"  1, 1, 1           numbers of voxels
//   "point3 p0", "point3 p1"                  (0 0 0), (1 1 1)  the box in medium space
//
// Spectra are interpolated, not colours, as pbrt-v4 does: the spectrum of a mixture of colours is not the
// mixture of their spectra.
#include <fmt/format.h>

#include "pbrt/media/grid_params.h"
#include "pbrt/media/medium_params.h"
#include "pbrt/phases/bulk.h"

namespace lacquer {
namespace {

/// One spectrum per voxel.
class SpectrumGrid {
  public:
    SpectrumGrid(Int3 resolution, std::span<const RGB> colours, const ColorSpace& space)
        : layout_(resolution), voxels_(layout_.StoredElements()) {
        std::vector<float> maxima;
        maxima.reserve(colours.size());
        for (int k = 0; k < resolution.z; ++k)
            for (int j = 0; j < resolution.y; ++j)
                for (int i = 0; i < resolution.x; ++i) {
                    const Voxel voxel = VoxelOf(colours[maxima.size()], space);
                    voxels_[layout_.Index(i, j, k)] = voxel;
                    maxima.push_back(voxel.scale * voxel.polynomial.MaxValue());
                }
        maxima_ = FloatGrid(resolution, maxima);
    }

    /// @param u  in the unit cube
    SampledSpectrum Lookup(Point3 u, const SampledWavelengths& lambda) const {
        const VoxelLayout::Corners c = layout_.CornersOf(u);
        SampledSpectrum sum(0);
        for (int k = 0; k < 2; ++k)
            for (int j = 0; j < 2; ++j)
                for (int i = 0; i < 2; ++i) {
                    const float w =
                        (i ? c.w.x : 1 - c.w.x) * (j ? c.w.y : 1 - c.w.y) * (k ? c.w.z : 1 - c.w.z);
                    const Voxel& v = voxels_[c.first + size_t(k) * layout_.SliceStride() +
                                             size_t(j) * layout_.RowStride() + size_t(i)];
                    if (v.scale > 0) sum += (w * v.scale) * v.polynomial.Sample(lambda);
                }
        return sum;
    }
    /// For each voxel the maximum over wavelengths; what lies between is below the interpolation of these.
    const FloatGrid& Maxima() const { return *maxima_; }
    size_t MemoryBytes() const { return voxels_.size() * sizeof(Voxel) + maxima_->MemoryBytes(); }

  private:
    struct Voxel {
        SigmoidPolynomial polynomial;
        float scale = 0;
    };
    static Voxel VoxelOf(RGB rgb, const ColorSpace& space) {
        const float scale = 2 * MaxComponent(rgb);  // as for every unbounded colour
        if (scale == 0) return {};
        return {space.ToPolynomial(rgb / scale), scale};
    }

    VoxelLayout layout_;
    std::vector<Voxel> voxels_;
    std::optional<FloatGrid> maxima_;
};

class RgbGrid final : public Medium {
  public:
    explicit RgbGrid(const MediumArgs& args)
        : Medium(ReadMediumPhase(args)),
          unitFromRender_(ReadUnitFromRender(args)),
          resolution_(ReadResolution(args.params)),
          illuminant_(args.params.ColorSpace().Illuminant()),
          sigma_a_(ReadGrid(args.params, "sigma_a")),
          sigma_s_(ReadGrid(args.params, "sigma_s")),
          Le_(ReadGrid(args.params, "Le")),
          scale_(ReadNonNegative(args.params, "scale", 1)),
          LeScale_(ReadNonNegative(args.params, "Lescale", 1)),
          majorants_(CheckedBounds(args.params)) {}

    MediumProperties At(Point3 p, const SampledWavelengths& lambda) const override {
        const Point3 u = unitFromRender_.Point(p);
        if (!InUnitCube(u)) return {};
        const auto lookup = [&](const std::optional<SpectrumGrid>& grid) {
            return grid ? grid->Lookup(u, lambda) * scale_ : SampledSpectrum(scale_);
        };
        MediumProperties properties{lookup(sigma_a_), lookup(sigma_s_), SampledSpectrum(0)};
        if (Le_) properties.Le = LeScale_ * Le_->Lookup(u, lambda) * illuminant_.Sample(lambda);
        return properties;
    }
    MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths&) const override {
        return {majorants_, unitFromRender_.Ray(ray), tMax, SampledSpectrum(1)};
    }
    bool IsEmissive() const override { return Le_ && LeScale_ > 0 && Le_->Maxima().Maximum() > 0; }
    size_t MemoryBytes() const override {
        size_t bytes = 0;
        for (const auto* grid : {&sigma_a_, &sigma_s_, &Le_})
            if (*grid) bytes += (*grid)->MemoryBytes();
        return bytes;
    }

  private:
    std::optional<SpectrumGrid> ReadGrid(const Params& params, const char* name) const {
        const std::vector<RGB> colours = params.GetRgbs(name);
        if (colours.empty()) return std::nullopt;
        CheckVoxelCount(params, name, colours.size(), resolution_);
        for (const RGB& rgb : colours)
            if (!(rgb.x >= 0 && rgb.y >= 0 && rgb.z >= 0))
                params.Fail(name, fmt::format("\"{}\" must not be negative, found ({} {} {})", name, rgb.x,
                                              rgb.y, rgb.z));
        return SpectrumGrid(resolution_, colours, params.ColorSpace());
    }
    MajorantGrid CheckedBounds(const Params& params) const {
        if (BulkPhaseModel::Of(GetPhaseModel()))
            params.Fail("bulk",
                        "a medium \"rgbgrid\" has its coefficients in its voxels; \"bulk\" is for "
                        "\"homogeneous\", \"uniformgrid\", \"cloud\" and \"nanovdb\"");
        if (!sigma_a_ && !sigma_s_)
            params.Fail("sigma_s",
                        "a medium \"rgbgrid\" needs \"rgb sigma_a\" or \"rgb sigma_s\", with one colour for "
                        "each voxel");
        if (Le_ && !sigma_a_)
            params.Fail("Le", "\"Le\" needs \"sigma_a\": what does not absorb does not emit");
        // What is not given is 1 in the whole box.
        const auto of = [&](const std::optional<SpectrumGrid>& grid) {
            return grid ? grid->Maxima().Maximum() : 1.f;
        };
        if (!std::isfinite(2 * scale_ * (of(sigma_a_) + of(sigma_s_))))
            params.Fail(sigma_a_ ? "sigma_a" : "sigma_s",
                        "the coefficients of this medium are too large for floats");
        const Vec3 meanFreePaths = scale_ * (of(sigma_a_) + of(sigma_s_)) * EdgeLengths(unitFromRender_);
        return BoundUnitCube(MajorantResolution(meanFreePaths, resolution_), [&](const Bounds3& box) {
            const auto within = [&](const std::optional<SpectrumGrid>& grid) {
                return grid ? grid->Maxima().Maximum(box) : 1.f;
            };
            return scale_ * (within(sigma_a_) + within(sigma_s_));
        });
    }

    Transform unitFromRender_;
    Int3 resolution_;
    const DenselySampledSpectrum& illuminant_;
    std::optional<SpectrumGrid> sigma_a_, sigma_s_;  ///< empty: 1
    std::optional<SpectrumGrid> Le_;                 ///< empty: emits nothing
    float scale_, LeScale_;
    MajorantGrid majorants_;
};

std::unique_ptr<Medium> Create(const MediumArgs& args) { return std::make_unique<RgbGrid>(args); }

}  // namespace

LACQUER_REGISTER(MediumKind, "rgbgrid", Create);

}  // namespace lacquer
