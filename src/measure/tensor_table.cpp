#include "measure/tensor_table.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "measure/half_difference.h"
#include "measure/spectral_subject.h"
#include "pbrt/bxdfs/bilinear_warp.h"
#include "pbrt/core/color_space.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/sampling.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer::measure {

namespace {

/// Polar angles crowd towards the normal by the square: MeasuredBrdf has the same.
SphericalAngles FacetAngles(Point2 u) {
    return {double(u.x) * double(u.x) * kPi / 2, (2 * double(u.y) - 1) * kPi};
}
Point2 GridPoint(size_t row, size_t column, size_t rows, size_t columns) {
    return {float(column) / float(columns - 1), float(row) / float(rows - 1)};
}
Point2 SquareOf(SphericalAngles a) {
    return {float(std::sqrt(a.theta * 2 / kPi)), float(a.phi / (2 * kPi) + 0.5)};
}
/// Solid angle over area of the square, without its constant factor.
double SolidAngleAt(Point2 u) { return double(u.x) * std::sin(FacetAngles(u).theta); }

/// Directions of wo, wavelengths and sizes of the tables. Azimuths cost a factor, so that the rest is coarser
/// where they count.
TensorTable Layout(bool isAnisotropic) {
    TensorTable t;
    // Steps of 6 degrees near the normal, finer ones toward the horizon, where Fresnel's factor rises.
    const int numTheta = isAnisotropic ? 14 : 24, numPhi = isAnisotropic ? 25 : 1;
    for (int i = 0; i < numTheta; ++i)
        t.theta.push_back(float(89.5 / 180 * kPi * std::sin(kPi / 2 * i / (numTheta - 1))));
    for (int i = 0; i < numPhi; ++i)
        t.phi.push_back(isAnisotropic ? float((2.0 * i / (numPhi - 1) - 1) * kPi) : 0.f);
    for (int lambda = 360; lambda <= 830; lambda += isAnisotropic ? 20 : 10)
        t.wavelengths.push_back(float(lambda));
    t.ndfRows = isAnisotropic ? 64 : 2;
    t.facetRows = 64;
    t.facetColumns = isAnisotropic ? 64 : 128;
    t.resolution = isAnisotropic ? 28 : 48;
    return t;
}

// ---- The distribution of facets
// ----------------------------------------------------------------------------

/// The facets that would send light where it goes, seen from several directions, each with the same weight;
/// and retroreflection, which alone knows of facets that face the horizon.
class FacetSurvey {
  public:
    FacetSurvey(const BsdfSubject& subject, const TableOptions& options, const TensorTable& layout)
        : subject_(subject),
          options_(options),
          layout_(layout),
          numAzimuths_(layout.IsIsotropic() ? 12 : 6) {}

    /// Density of facets over the grid of `ndf`, to a factor.
    std::vector<float> Density(Observer* observer) const {
        const size_t rows = layout_.ndfRows, columns = layout_.facetColumns, size = rows * columns;
        const size_t views = NumViews();
        std::vector<double> seen(views * size);
        ParallelFor(int64_t(columns), [&](int64_t column) {
            Rng rng(Hash(options_.seed, column, 5));
            for (size_t row = 0; row < rows; ++row)
                for (size_t view = 0; view < views; ++view)
                    seen[view * size + row * columns + size_t(column)] =
                        Seen(GridPoint(row, size_t(column), rows, columns), view, rng);
            if (observer) observer->Advance(1);
        });
        // A share for what none of them has met much of: light near the horizon, and nothing is divided by 0.
        std::vector<double> density(size, 0.3 / (2 * kPi));
        for (size_t view = 0; view < views; ++view) {
            const double* of = &seen[view * size];
            double mass = 0;
            for (size_t i = 0; i < size; ++i)
                mass += of[i] * SolidAngleAt(GridPoint(i / columns, i % columns, rows, columns));
            mass *= 2 * kPi * kPi / double(size);
            for (size_t i = 0; i < size && mass > 0; ++i) density[i] += of[i] / mass / double(views);
        }
        if (subject_.IsStochastic()) density = Smoothed(density, columns);
        return std::vector<float>(density.begin(), density.end());
    }

  private:
    static constexpr double kPolarDeg[] = {0, 30, 50, 65, 75, 83, 88};

    /// Views of isotropic materials have all azimuths at once, which a facet is turned by.
    size_t NumViews() const {
        return 1 + std::size(kPolarDeg) * (layout_.IsIsotropic() ? 1 : size_t(numAzimuths_));
    }

    /// f cos(theta_i), to which the density of facets is proportional. @param view  0: retroreflection
    double Seen(Point2 u, size_t view, Rng& rng) const {
        const SphericalAngles facet = FacetAngles(u);
        if (view == 0) return Radiance(DirectionAt(facet), DirectionAt(facet), rng);
        const size_t polar = (view - 1) % std::size(kPolarDeg);
        const double theta = kPolarDeg[polar] * kPi / 180;
        if (!layout_.IsIsotropic()) {
            const size_t azimuth = (view - 1) / std::size(kPolarDeg);
            return Seen({theta, double(azimuth) * 2 * kPi / numAzimuths_}, facet, rng);
        }
        double sum = 0;
        for (int i = 0; i < numAzimuths_; ++i)
            sum += Seen({theta, 0}, {facet.theta, (i + 0.5) * kPi / numAzimuths_}, rng);
        return sum / numAzimuths_;
    }
    double Seen(SphericalAngles wo, SphericalAngles facet, Rng& rng) const {
        const Vec3 o = DirectionAt(wo), m = DirectionAt(facet);
        return Dot(o, m) > 0 ? Radiance(o, Reflect(o, m), rng) : 0;
    }
    double Radiance(Vec3 wo, Vec3 wi, Rng& rng) const {
        if (!(wo.z > 0) || !(wi.z > 0)) return 0;
        const int64_t batches =
            subject_.IsStochastic() ? std::max(2, options_.samples / 4) : subject_.NumVariants();
        return std::max(
            0.0, subject_.Evaluate(wo, wi, TransportMode::Radiance, batches, rng, double(wi.z)).Luminance());
    }

    /// Noise here would be noise between the samples of the spectra.
    static std::vector<double> Smoothed(std::vector<double> table, size_t columns) {
        for (int pass = 0; pass < 2; ++pass) {
            const std::vector<double> before = table;
            for (size_t i = 0; i < table.size(); ++i) {
                const size_t column = i % columns;
                const double left = before[column > 0 ? i - 1 : i],
                             right = before[column + 1 < columns ? i + 1 : i];
                table[i] = (left + 2 * before[i] + right) / 4;
            }
        }
        return table;
    }

    const BsdfSubject& subject_;
    const TableOptions& options_;
    const TensorTable& layout_;
    int numAzimuths_;
};

/// sigma: the area of all facets as wo sees it.
void AddProjectedAreas(TensorTable* t) {
    const size_t rows = t->ndfRows, columns = t->facetColumns;
    // The integral takes the facets of isotropic materials all around.
    const size_t integralRows = std::max<size_t>(rows, 64);
    const BilinearTables ndf(t->ndf, rows, columns);
    t->sigma.resize(rows * columns);
    ParallelFor(int64_t(rows * columns), [&](int64_t i) {
        const Vec3 wo =
            DirectionAt(FacetAngles(GridPoint(size_t(i) / columns, size_t(i) % columns, rows, columns)));
        double sum = 0;
        for (size_t row = 0; row < integralRows; ++row)
            for (size_t column = 0; column < columns; ++column) {
                const Point2 u((float(column) + 0.5f) / float(columns),
                               (float(row) + 0.5f) / float(integralRows));
                const double visible = double(Dot(wo, DirectionAt(FacetAngles(u))));
                if (visible > 0) sum += double(ndf.Evaluate(u, {})) * visible * SolidAngleAt(u);
            }
        t->sigma[size_t(i)] = float(sum * 2 * kPi * kPi / double(integralRows * columns));
    });
}

/// The facets that wo sees and by which it sees light from above; of others a trace, for what lies within
/// their cells. So the horizon lies at the edge of the numbers that draw them, where all that the spectra are
/// is 0 or more: readers take offence at negative values, and zeros a cell below the horizon would be divided
/// by a cosine of next to nothing.
void AddVisibleFacets(TensorTable* t) {
    constexpr double kTrace = 0.005;
    const size_t rows = t->facetRows, columns = t->facetColumns;
    const BilinearTables ndf(t->ndf, t->ndfRows, columns);
    for (const float phi : t->phi)
        for (const float theta : t->theta) {
            const Vec3 wo = DirectionAt({double(theta), double(phi)});
            for (size_t i = 0; i < rows * columns; ++i) {
                const Point2 u = GridPoint(i / columns, i % columns, rows, columns);
                const Vec3 wm = DirectionAt(FacetAngles(u));
                const double visible = std::max(0.0, double(Dot(wo, wm)));
                const double share = Reflect(wo, wm).z > 0 ? 1 : kTrace;
                t->vndf.push_back(float(double(ndf.Evaluate(u, {})) * visible * share * SolidAngleAt(u)));
            }
        }
}

// ---- Spectra
// -----------------------------------------------------------------------------------------------

/// Fills the spectra of one direction of wo.
class SliceFiller {
  public:
    SliceFiller(const SpectralSubject& subject, int64_t numSamples, TensorTable* table)
        : subject_(subject),
          numSamples_(numSamples),
          table_(table),
          ndf_(table->ndf, table->ndfRows, table->facetColumns),
          sigma_(table->sigma, table->ndfRows, table->facetColumns),
          vndf_(table->vndf, table->facetRows, table->facetColumns) {}

    void Fill(size_t slice, uint64_t seed) const {
        const TensorTable& t = *table_;
        const size_t n = t.resolution, numTheta = t.theta.size();
        const SphericalAngles angles{double(t.theta[slice % numTheta]), double(t.phi[slice / numTheta])};
        SliceBlend blend;
        blend.slice[0] = slice;
        const View view{DirectionAt(angles), sigma_.Evaluate(SquareOf(angles), {}), blend};
        Rng rng(Hash(seed, slice, 6));
        // Isotropic materials are the same on both sides of the plane of wo and the normal.
        const size_t rows = t.IsIsotropic() ? (n + 1) / 2 : n;
        for (size_t row = 0; row < rows; ++row)
            for (size_t column = 0; column < n; ++column) FillPoint(view, row, column, rng);
        SetLuminance(slice);
    }

  private:
    struct View {
        Vec3 wo;
        float projectedArea;
        SliceBlend blend;
    };

    float* SpectrumAt(size_t slice, size_t wavelength, size_t row, size_t column) const {
        const size_t n = table_->resolution;
        return &table_->spectra[((slice * table_->wavelengths.size() + wavelength) * n + row) * n + column];
    }

    /// f 4 sigma cos(theta_i) / D, which MeasuredBrdf multiplies again; 0 below the horizon.
    void FillPoint(const View& view, size_t row, size_t column, Rng& rng) const {
        const size_t n = table_->resolution;
        const Point2 facet = vndf_.Sample(GridPoint(row, column, n, n), view.blend).p;
        const Vec3 wi = Reflect(view.wo, DirectionAt(FacetAngles(facet)));
        std::vector<double> mean(table_->wavelengths.size());
        for (int64_t sample = 0; wi.z > 0 && sample < numSamples_; ++sample) {
            subject_.EvaluateOnce(sample, view.wo, wi, TransportMode::Radiance, rng,
                                  [&](SampledSpectrum f, size_t first, size_t count) {
                                      for (size_t i = 0; i < count; ++i)
                                          mean[first + i] += double(f[int(i)]) / double(numSamples_);
                                  });
            rng.NextBits();
        }
        const float scale = 4 * view.projectedArea * wi.z / ndf_.Evaluate(facet, {});
        for (size_t i = 0; i < mean.size(); ++i) {
            const float value = mean[i] > 0 ? float(mean[i]) * scale : 0;
            *SpectrumAt(view.blend.slice[0], i, row, column) = value;
            if (table_->IsIsotropic()) *SpectrumAt(view.blend.slice[0], i, n - 1 - row, column) = value;
        }
    }

    /// For drawing directions: nowhere 0, for between its samples may be light.
    void SetLuminance(size_t slice) const {
        const size_t size = Sqr(table_->resolution), numWavelengths = table_->wavelengths.size();
        float* luminance = &table_->luminance[slice * size];
        double sum = 0;
        for (size_t i = 0; i < size; ++i) {
            double value = 0;
            for (size_t k = 0; k < numWavelengths; ++k)
                value +=
                    double(CieY().Evaluate(table_->wavelengths[k])) * double(SpectrumAt(slice, k, 0, 0)[i]);
            luminance[i] = float(std::max(0.0, value));
            sum += double(luminance[i]);
        }
        const double floor = sum > 0 ? 0.01 * sum / double(size) : 1;
        for (size_t i = 0; i < size; ++i) luminance[i] += float(floor);
    }

    const SpectralSubject& subject_;
    int64_t numSamples_;
    TensorTable* table_;
    BilinearTables ndf_, sigma_;
    BilinearWarp vndf_;
};

// ---- The file
// ----------------------------------------------------------------------------------------------

struct TensorField {
    std::string name;
    std::vector<size_t> shape;
    bool isFloat;
    std::string bytes;
};
TensorField FloatField(const std::string& name, std::vector<size_t> shape, const std::vector<float>& values) {
    return {name, std::move(shape), true,
            std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float))};
}

template <class T>
void Append(std::string* bytes, T value) {
    bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::string FileOf(const std::vector<TensorField>& fields) {
    constexpr int kUInt8 = 1, kFloat32 = 10;
    size_t offset = 18;
    for (const TensorField& f : fields) offset += 2 + f.name.size() + 2 + 1 + 8 + 8 * f.shape.size();
    std::string bytes("tensor_file\0\1\0", 14);
    Append(&bytes, uint32_t(fields.size()));
    for (const TensorField& f : fields) {
        Append(&bytes, uint16_t(f.name.size()));
        bytes += f.name;
        Append(&bytes, uint16_t(f.shape.size()));
        Append(&bytes, uint8_t(f.isFloat ? kFloat32 : kUInt8));
        Append(&bytes, uint64_t(offset));
        for (const size_t n : f.shape) Append(&bytes, uint64_t(n));
        offset += f.bytes.size();
    }
    for (const TensorField& f : fields) bytes += f.bytes;
    return bytes;
}

}  // namespace

bool IsAnisotropic(const BsdfSubject& subject, uint64_t seed) {
    constexpr int kPairs = 64;
    const int64_t batches = subject.IsStochastic() ? 256 : subject.NumVariants();
    std::atomic<int> numPairs = 0, numDifferent = 0;
    ParallelFor(kPairs, [&](int64_t i) {
        Rng rng(Hash(seed, i, 7));
        const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
        const float turn = 2 * float(kPi) * rng.Uniform(), c = std::cos(turn), s = std::sin(turn);
        const auto drawn = subject.At(i).Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {.rng = &rng});
        if (!drawn || !(drawn->wi.z > 0) || !(wo.z > 0)) return;
        const auto at = [&](Vec3 o, Vec3 in) {
            return subject.Evaluate(o, in, TransportMode::Radiance, batches, rng);
        };
        const ColorMean a = at(wo, drawn->wi),
                        b = at(TurnedAboutNormal(wo, c, s), TurnedAboutNormal(drawn->wi, c, s));
        const double noise =
            subject.IsStochastic() ? 3 * std::hypot(a.LuminanceError(), b.LuminanceError()) : 0;
        const double least = std::max(noise, 0.02 * std::max(a.Luminance(), b.Luminance()));
        ++numPairs;
        if (std::abs(a.Luminance() - b.Luminance()) > least) ++numDifferent;
    });
    return numDifferent > 0 && 4 * numDifferent >= numPairs;
}

TensorTable TabulateTensor(const SceneMaterial& material, Point2 uv, const TableOptions& options,
                           Observer* observer) {
    const BsdfSubject& bsdf = *material.bsdf;
    TensorTable t = Layout(IsAnisotropic(bsdf, options.seed));
    const size_t numSlices = t.theta.size() * t.phi.size(), size = Sqr(t.resolution);
    if (observer) observer->Begin("Tabulating", int64_t(numSlices + t.facetColumns), "");
    t.ndf = FacetSurvey(bsdf, options, t).Density(observer);
    AddProjectedAreas(&t);
    AddVisibleFacets(&t);
    t.luminance.resize(numSlices * size);
    t.spectra.resize(numSlices * t.wavelengths.size() * size);
    const SpectralSubject spectral(*material.setup.material, uv, t.wavelengths, material.setup.entity.loc);
    const int64_t numSamples = bsdf.IsStochastic() ? std::max(1, options.samples) : bsdf.NumVariants();
    const SliceFiller filler(spectral, numSamples, &t);
    ParallelFor(int64_t(numSlices), [&](int64_t slice) {
        filler.Fill(size_t(slice), options.seed);
        if (observer) observer->Advance(1);
    });
    if (observer) observer->End();
    return t;
}

std::string TensorTable::Bytes(const std::string& description) const {
    const size_t a = phi.size(), b = theta.size(), n = resolution;
    return FileOf({FloatField("theta_i", {b}, theta),
                   FloatField("phi_i", {a}, phi),
                   FloatField("ndf", {ndfRows, facetColumns}, ndf),
                   FloatField("sigma", {ndfRows, facetColumns}, sigma),
                   FloatField("vndf", {a, b, facetRows, facetColumns}, vndf),
                   FloatField("luminance", {a, b, n, n}, luminance),
                   FloatField("spectra", {a, b, wavelengths.size(), n, n}, spectra),
                   FloatField("wavelengths", {wavelengths.size()}, wavelengths),
                   {"description", {description.size()}, false, description},
                   {"jacobian", {1}, false, "\1"}});
}

}  // namespace lacquer::measure
