#include "pbrt/lights/emission.h"

#include <fmt/format.h>

#include <algorithm>
#include <mutex>
#include <unordered_map>

#include "pbrt/core/hash_bytes.h"
#include "pbrt/core/sampling.h"

namespace lacquer {
namespace {

using Table = DenselySampledSpectrum;

/// The tables that are in use.
class SharedTables {
  public:
    /// A table of the spectrum: the one that there is, if some light has an equal one. Thread-safe.
    std::shared_ptr<const Table> Get(const Spectrum& spectrum) {
        auto table = std::make_shared<const Table>(spectrum);
        const std::lock_guard lock(mutex_);
        std::weak_ptr<const Table>& slot = tables_[HashOf(*table)];
        if (std::shared_ptr<const Table> known = slot.lock(); known && IsEqual(*known, *table)) return known;
        slot = table;
        ForgetUnused();
        return table;
    }

  private:
    static uint64_t HashOf(const Table& table) {
        const auto bytes = std::as_bytes(table.Values());
        return HashOfBytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    static bool IsEqual(const Table& a, const Table& b) { return std::ranges::equal(a.Values(), b.Values()); }
    void ForgetUnused() {
        if (tables_.size() < forgetAt_) return;
        std::erase_if(tables_, [](const auto& entry) { return entry.second.expired(); });
        forgetAt_ = 2 * tables_.size() + kFew;
    }

    static constexpr size_t kFew = 64;
    std::mutex mutex_;
    std::unordered_map<uint64_t, std::weak_ptr<const Table>> tables_;
    size_t forgetAt_ = kFew;
};

std::shared_ptr<const Spectrum> FastSpectrum(const Params& params, std::string_view parameter) {
    static SharedTables tables;
    std::unique_ptr<Spectrum> given = params.GetSpectrum(parameter, SpectrumKind::Illuminant);
    if (given && params.GetRgb(parameter)) return given;
    const Spectrum* const spectrum = given ? given.get() : &params.ColorSpace().Illuminant();
    return tables.Get(*spectrum);
}

/// What InnerProduct() takes: the sum over a huge colour overflows before its scale, and not after it.
class ScaledSpectrum final : public Spectrum {
  public:
    ScaledSpectrum(const Spectrum& spectrum, float scale) : spectrum_(spectrum), scale_(scale) {}
    float Evaluate(float lambda) const override { return spectrum_.Evaluate(lambda) * scale_; }
    SampledSpectrum Sample(const SampledWavelengths& lambda) const override {
        return spectrum_.Sample(lambda) * scale_;
    }
    float MaxValue() const override { return spectrum_.MaxValue() * scale_; }

  private:
    const Spectrum& spectrum_;
    float scale_;
};

}  // namespace

Emission ReadEmission(const Params& params, std::string_view parameter, float scale) {
    Emission emission{FastSpectrum(params, parameter)};
    emission.scale = EmissionScale(*emission.spectrum, params, parameter, scale);
    emission.luminance = RequireFinite(
        params, parameter, InnerProduct(ScaledSpectrum(*emission.spectrum, emission.scale), CieY()));
    RequireFinite(params, parameter, emission.MaxValue());
    return emission;
}

float ReadScale(const Params& params) {
    const float scale = params.GetFloat("scale", 1);
    if (!(scale >= 0) || !std::isfinite(scale))
        params.Fail("scale", fmt::format("expected a finite scale that is not negative, found {}", scale));
    return scale;
}

float ReadQuantity(const Params& params, std::string_view name) {
    return std::max(0.f, RequireFinite(params, name, params.GetFloat(name, 0)));
}

float RequireFinite(const Params& params, std::string_view parameter, float value) {
    if (!std::isfinite(value))
        params.Fail(parameter,
                    fmt::format("the emission of this light must be finite, but \"{}\" makes it {}",
                                parameter, std::isnan(value) ? "no number" : fmt::to_string(value)));
    return value;
}

Vec3 ReadDirection(const Params& params, Point3 from, Point3 to) {
    // In double: neither may the difference of two huge points overflow nor its square underflow.
    const glm::dvec3 d = glm::dvec3(to) - glm::dvec3(from);
    const double length = glm::length(d);
    if (!(length > 0) || !std::isfinite(length))
        params.Fail(
            "to", "\"from\" and \"to\" must be finite and differ, for they give the direction of the light");
    return Vec3(d / length);
}

LightEmission EmissionThroughSphere(const BoundingSphere& sphere, Vec3 w, SampledSpectrum L, Point2 u,
                                    float pdfDirection) {
    const Point2 d = SampleUniformDiskConcentric(u);
    const Vec3 onDisk = Frame::FromZ(w).FromLocal({d.x, d.y, -1});
    LightEmission emitted;
    emitted.L = L;
    emitted.w = w;
    emitted.p = sphere.center + sphere.radius * onDisk;
    emitted.pdfPosition = PdfThroughSphere(sphere);
    emitted.pdfDirection = pdfDirection;
    return emitted;
}

BoundingSphere BoundingSphereOf(const Bounds3& sceneBounds) {
    if (sceneBounds.IsEmpty()) return {};
    const float radius = 0.5f * Length(sceneBounds.Diagonal());
    // Rays towards what is beyond the scene go twice as far, and cannot be traced beyond 1.8e18; nor could
    // the square of the radius be a float, which every power of a distant light has.
    constexpr float kLargest = 8e17f;
    if (!(radius < kLargest)) return {Point3(0), kLargest};
    return {sceneBounds.Center(), std::max(radius, 1e-18f)};
}

}  // namespace lacquer
