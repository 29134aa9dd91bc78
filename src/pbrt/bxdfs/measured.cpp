#include "pbrt/bxdfs/measured.h"

#include <fmt/format.h>

#include "pbrt/bxdfs/tensor_file.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer {
namespace {

/// Polar angles crowd towards the normal, where highlights are.
float ThetaToU(float theta) { return std::sqrt(theta * (2 / Pi)); }
float UToTheta(float u) { return u * u * (Pi / 2); }
float PhiToU(float phi) { return phi * Inv2Pi + 0.5f; }
float UToPhi(float u) { return (2 * u - 1) * Pi; }

/// Polar angle, exact also near the pole.
float Theta(Vec3 w) { return ATan2(std::sqrt(w.x * w.x + w.y * w.y), w.z); }

/// Solid angle of facet normals over area of the square: d omega = 2 pi^2 u sin(theta) du dv.
float SolidAngle(float u) { return std::max(2 * Sqr(Pi) * u * std::sin(UToTheta(u)), 1e-20f); }

void CheckIncreasing(const TensorFile& file, std::string_view name, const std::vector<float>& values) {
    for (size_t i = 1; i < values.size(); ++i)
        if (!(values[i] > values[i - 1]))
            file.Fail(name, fmt::format("values must increase, but {} follows {}", values[i], values[i - 1]));
}

void CheckShape(const TensorFile& file, std::string_view name, const FloatTensor& tensor,
                const std::vector<size_t>& leading) {
    for (size_t d = 0; d < leading.size(); ++d)
        if (tensor.shape[d] != leading[d])
            file.Fail(name, fmt::format("dimension {} has {} entries; expected {}, as the other fields have",
                                        d + 1, tensor.shape[d], leading[d]));
}

/// The last two dimensions are rows and columns of the tables.
template <class Tables>
Tables TablesOf(FloatTensor tensor) {
    const size_t n = tensor.shape.size();
    return Tables(std::move(tensor.values), tensor.shape[n - 2], tensor.shape[n - 1]);
}

}  // namespace

struct MeasuredBrdf::Coordinates {
    Point2 facet;      ///< of the half vector
    SliceBlend blend;  ///< of wo
    float scale;  ///< density over solid angle of wi per density over the square of facets; 0: impossible
};

std::shared_ptr<const MeasuredBrdf> MeasuredBrdf::Read(const std::string& path, const FileLoc& loc) {
    const TensorFile file(path, loc);
    auto brdf = std::make_shared<MeasuredBrdf>();
    brdf->theta_ = file.Floats("theta_i", 1).values;
    brdf->phi_ = file.Floats("phi_i", 1).values;
    brdf->wavelengths_ = file.Floats("wavelengths", 1).values;
    CheckIncreasing(file, "theta_i", brdf->theta_);
    CheckIncreasing(file, "phi_i", brdf->phi_);
    CheckIncreasing(file, "wavelengths", brdf->wavelengths_);
    if (file.Bytes("jacobian")[0] == 0)
        file.Fail("jacobian", "is 0; expected 1: values over the density of visible normals");

    // One azimuth: the same for all, and facets are counted from that of wo.
    brdf->isotropic_ = brdf->phi_.size() <= 2;
    if (!brdf->isotropic_) {
        const float range = brdf->phi_.back() - brdf->phi_.front();
        if (std::abs(range - 2 * Pi) > 0.01f)
            file.Fail("phi_i", fmt::format("azimuths over {} degrees; expected 360", Degrees(range)));
    }

    const size_t numPhi = brdf->phi_.size(), numTheta = brdf->theta_.size();
    const auto read = [&](std::string_view name, size_t dimensions, const std::vector<size_t>& leading) {
        FloatTensor tensor = file.Floats(name, dimensions);
        CheckShape(file, name, tensor, leading);
        for (size_t d = dimensions - 2; d < dimensions; ++d)
            if (tensor.shape[d] < 2) file.Fail(name, "a table has one row or column; expected at least two");
        return tensor;
    };
    brdf->ndf_ = TablesOf<BilinearTables>(read("ndf", 2, {}));
    brdf->sigma_ = TablesOf<BilinearTables>(read("sigma", 2, {}));
    brdf->vndf_ = TablesOf<BilinearWarp>(read("vndf", 4, {numPhi, numTheta}));
    FloatTensor luminance = read("luminance", 4, {numPhi, numTheta});
    brdf->spectra_ = TablesOf<BilinearTables>(read(
        "spectra", 5, {numPhi, numTheta, brdf->wavelengths_.size(), luminance.shape[2], luminance.shape[3]}));
    brdf->luminance_ = TablesOf<BilinearWarp>(std::move(luminance));
    return brdf;
}

MeasuredBrdf::Coordinates MeasuredBrdf::CoordinatesOf(Vec3 wo, Vec3 wi) const {
    Coordinates c{};
    const Vec3 sum = wo + wi;
    if (!(LengthSquared(sum) > 0)) return c;
    const Vec3 wm = Normalize(sum);
    const float phi_o = ATan2(wo.y, wo.x), phi_m = ATan2(wm.y, wm.x);
    c.blend = SliceBlend().Refined(phi_, phi_o).Refined(theta_, Theta(wo));
    c.facet = {ThetaToU(Theta(wm)), PhiToU(isotropic_ ? phi_m - phi_o : phi_m)};
    c.facet.y -= std::floor(c.facet.y);
    // Half vectors move half as fast as wi does: [Walter et al. 2007] eq. 14.
    c.scale = 1 / (4 * std::max(Dot(wo, wm), 1e-12f) * SolidAngle(c.facet.x));
    return c;
}

MeasuredBrdf::Value MeasuredBrdf::Evaluate(Vec3 wo, Vec3 wi, SampledSpectrum lambda) const {
    const Coordinates c = CoordinatesOf(wo, wi);
    if (!(c.scale > 0)) return {};
    const BilinearWarp::Point u = vndf_.Invert(c.facet, c.blend);
    SampledSpectrum f;
    for (int i = 0; i < kNumWavelengths; ++i)
        f.Set(i, spectra_.Evaluate(u.p, c.blend.Refined(wavelengths_, lambda[i])));
    const Point2 u_o(ThetaToU(Theta(wo)), PhiToU(ATan2(wo.y, wo.x)));
    // The spectra are f times this, so that they are smooth [Dupuy and Jakob 2018, sec. 4].
    const float projectedArea = sigma_.Evaluate(u_o, {}), density = ndf_.Evaluate(c.facet, {});
    const float factor = projectedArea > 0 ? density / (4 * projectedArea * wi.z) : 0.f;
    return {Max(f * factor, SampledSpectrum(0)), u.pdf * luminance_.Pdf(u.p, c.blend) * c.scale};
}

float MeasuredBrdf::Pdf(Vec3 wo, Vec3 wi) const {
    const Coordinates c = CoordinatesOf(wo, wi);
    if (!(c.scale > 0)) return 0;
    const BilinearWarp::Point u = vndf_.Invert(c.facet, c.blend);
    return u.pdf * luminance_.Pdf(u.p, c.blend) * c.scale;
}

Vec3 MeasuredBrdf::Sample(Vec3 wo, Point2 u) const {
    const float phi_o = ATan2(wo.y, wo.x);
    const SliceBlend blend = SliceBlend().Refined(phi_, phi_o).Refined(theta_, Theta(wo));
    const Point2 facet = vndf_.Sample(luminance_.Sample(u, blend).p, blend).p;
    const float theta = UToTheta(facet.x), phi = UToPhi(facet.y) + (isotropic_ ? phi_o : 0);
    return Reflect(wo, SphericalDirection(std::sin(theta), std::cos(theta), phi));
}

BxDFValue MeasuredBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    // Seen from below, the whole surface is turned over.
    if (wo.z < 0) {
        wo = -wo;
        wi = -wi;
    }
    const MeasuredBrdf::Value value = brdf_->Evaluate(wo, wi, lambda_);
    return {value.f, value.pdf, context.needsPdf ? brdf_->Pdf(wi, wo) : 0.f};
}

float MeasuredBxDF::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return 0;
    return wo.z < 0 ? brdf_->Pdf(-wo, -wi) : brdf_->Pdf(wo, wi);
}

std::optional<BxDFSample> MeasuredBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                               const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    const float side = wo.z < 0 ? -1.f : 1.f;
    const Vec3 wi = Normalize(brdf_->Sample(side * wo, u.direction));
    if (!(wi.z > 0)) return std::nullopt;
    // The density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
    const BxDFValue value = Evaluate(wo, side * wi, context);
    if (!(value.pdf > 0) || !std::isfinite(value.pdf)) return std::nullopt;
    return BxDFSample{.wi = side * wi,
                      .weight = value.f * (wi.z / value.pdf),
                      .pdf = value.pdf,
                      .pdfReverse = value.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

}  // namespace lacquer
