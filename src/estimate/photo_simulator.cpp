#include "estimate/photo_simulator.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "pbrt/core/check.h"
#include "pbrt/core/error.h"

namespace lacquer::estimate {
namespace {

const PhotoSettings& Checked(const PhotoSettings& s) {
    if (s.resolution < 64 || s.resolution % 16 != 0)
        throw std::invalid_argument(
            fmt::format("the resolution is {}, which is not a multiple of 16 from 64 on", s.resolution));
    if (s.averaging < 1 || s.averaging > 64)
        throw std::invalid_argument(
            fmt::format("pixels are means of {0} x {0} simulated ones, expected 1 to 64", s.averaging));
    if (!(s.extent > 0) || !(s.distance > 0) || !std::isfinite(s.extent) || !std::isfinite(s.distance))
        throw std::invalid_argument(fmt::format(
            "the sample has a side of {} cm at a distance of {} cm; both have to be positive and finite",
            s.extent, s.distance));
    return s;
}

}  // namespace

Prior PriorAt(const ModelParameter& parameter, PriorSet priors, double distance) {
    const Prior prior = priors == PriorSet::Demo ? parameter.demoPrior : parameter.prior;
    const double ratio = distance / kPriorDistance;
    const double scale = parameter.name == "light" ? ratio * ratio : parameter.name == "vig" ? ratio : 1;
    return {scale * prior.mean, scale * prior.sd, scale * prior.low, scale * prior.high};
}

std::vector<std::string> DefaultSummaries(const MaterialModel& model) {
    if (model.ReflectanceKind() == Reflectance::Metal) return {"colour", "columns", "columnspectrum"};
    return {"colour", "rings", "spectrum", "pyramid"};
}

PhotoWorkspace::PhotoWorkspace(const MaterialModel& model, const PhotoSettings& settings,
                               const std::vector<std::string>& families)
    : settings_(Checked(settings)),
      vignette_(size_t(model.Find("vig"))),
      axisX_(size_t(model.Find("axis_x"))),
      axisY_(size_t(model.Find("axis_y"))),
      run_(model.MakeRun(settings.FineGrid(), settings.kinds, {})),
      photo_(settings.FineGrid(), settings.distance, settings.brdf),
      summaries_(families, settings.Grid(), settings.vgg) {}

FlashSettings PhotoWorkspace::SettingsOf(std::span<const double> parameters) const {
    return {parameters[0], parameters[vignette_], parameters[axisX_], parameters[axisY_]};
}

void PhotoWorkspace::Forward(std::span<const double> parameters, uint64_t seed, std::span<double> values) {
    if (!hasSeed_ || seed != seed_) run_->SetSeed(seed);
    hasSeed_ = true;
    seed_ = seed;
    run_->Forward(parameters, &surface_);
    photo_.Forward(surface_, SettingsOf(parameters), settings_.averaging > 1 ? &fine_ : &linear_);
    if (settings_.averaging > 1) AverageClamped(fine_, settings_.averaging, &linear_);
    PlanarImage toned = summaries_.TakeImage();
    ApplyTone(settings_.tone, linear_, &toned);
    if (settings_.isRounded) RoundToBytes(&toned);
    summaries_.Forward(std::move(toned), values);
}

std::vector<double> PhotoWorkspace::Backward(std::span<const double> parameters, std::span<const double> by) {
    PlanarImage byImage = summaries_.Backward(by);
    ToneAdjoint(settings_.tone, linear_, summaries_.Image(), &byImage);
    if (settings_.averaging > 1) byImage = AverageAdjoint(fine_, settings_.averaging, byImage);
    Surface bySurface = surface_.ZeroAdjoint();
    FlashSettings bySettings{0, 0, 0, 0};
    photo_.Backward(surface_, SettingsOf(parameters), byImage, &bySurface, &bySettings);
    std::vector<double> out(parameters.size(), 0.);
    run_->Backward(parameters, surface_, &bySurface, out);
    out[0] += bySettings.light;
    out[vignette_] += bySettings.vignette;
    out[axisX_] += bySettings.axisX;
    out[axisY_] += bySettings.axisY;
    return out;
}

/// A workspace for as long as this object lives.
class PhotoSimulator::Lease {
  public:
    explicit Lease(const PhotoSimulator& owner) : owner_(owner) {
        {
            const std::lock_guard lock(owner.mutex_);
            if (!owner.idle_.empty()) {
                workspace_ = std::move(owner.idle_.back());
                owner.idle_.pop_back();
            }
        }
        if (!workspace_)
            workspace_ = std::make_unique<PhotoWorkspace>(owner.model_, owner.settings_, owner.families_);
    }
    ~Lease() {
        const std::lock_guard lock(owner_.mutex_);
        owner_.idle_.push_back(std::move(workspace_));
    }
    Lease(const Lease&) = delete;
    Lease& operator=(const Lease&) = delete;
    PhotoWorkspace* operator->() const { return workspace_.get(); }

  private:
    const PhotoSimulator& owner_;
    std::unique_ptr<PhotoWorkspace> workspace_;
};

/// Holds its workspace until it is gone.
class PhotoSimulator::Run final : public DifferentiableRun {
  public:
    Run(const PhotoSimulator& owner, const Vector& x, uint64_t seed)
        : owner_(owner),
          lease_(owner),
          parameters_(owner.AllParameters(x)),
          values_(Eigen::Index(owner.names_.size())) {
        lease_->Forward(parameters_, seed, {values_.data(), size_t(values_.size())});
    }
    const Vector& Summaries() const override { return values_; }
    Vector Gradient(const Vector& adjoint) const override {
        const auto by = lease_->Backward(parameters_, {adjoint.data(), size_t(adjoint.size())});
        Vector gradient(Eigen::Index(owner_.freeIndices_.size()));
        for (size_t i = 0; i < owner_.freeIndices_.size(); ++i)
            gradient[Eigen::Index(i)] = by[owner_.freeIndices_[i]];
        return gradient;
    }

  private:
    const PhotoSimulator& owner_;
    Lease lease_;
    std::vector<double> parameters_;
    Vector values_;
};

/// Light and what reflects it are seen as products.
static const char* ScaleOf(const std::string& name) {
    constexpr std::string_view kReflectances[] = {"r", "g", "b", "topf0", "fr", "fg", "fb"};
    return std::ranges::count(kReflectances, name) > 0 ? "light" : "";
}

/// What is never negative stays so, and what is a part of 1 (an albedo, a roughness) is no more.
static void CheckLimits(const ModelParameter& parameter, const Prior& prior) {
    const Prior& own = parameter.prior;
    const bool isPart = parameter.unit.empty() && own.low >= 0 && own.high <= 1;
    if ((own.low >= 0 && prior.low < 0) || (isPart && prior.high > 1))
        throw std::invalid_argument(fmt::format("the prior of {} reaches from {:g} to {:g}; expected {}",
                                                parameter.name, prior.low, prior.high,
                                                isPart ? "limits from 0 to 1" : "no negative limits"));
}

ParameterSpace PhotoSimulator::MakeSpace(const FreeParameters& free) {
    const auto known = [&](const std::string& name) {
        if (model_.Find(name) >= 0) return;
        std::vector<std::string> names;
        for (const ModelParameter& parameter : model_.Parameters()) names.emplace_back(parameter.name);
        throw std::invalid_argument(
            fmt::format("model {} has no parameter \"{}\"{}", model_.Name(), name, DidYouMean(name, names)));
    };
    for (const auto& [name, value] : free.fixed) known(name);
    for (const auto& [name, prior] : free.replacedPriors) known(name);
    for (const std::string& name : free.alsoFree) known(name);
    std::vector<Parameter> parameters;
    std::string scaled;
    const auto table = model_.Parameters();
    for (size_t i = 0; i < table.size(); ++i) {
        const std::string name(table[i].name);
        const auto replaced = free.replacedPriors.find(name);
        Prior prior = replaced != free.replacedPriors.end()
                          ? replaced->second
                          : PriorAt(table[i], free.priors, settings_.distance);
        if (replaced != free.replacedPriors.end()) CheckLimits(table[i], prior);
        fixedParameters_.push_back(table[i].optional ? table[i].fixedValue : prior.mean);
        const auto fixed = free.fixed.find(name);
        if (fixed != free.fixed.end()) {
            if (!(fixed->second >= prior.low && fixed->second <= prior.high) &&
                fixed->second != fixedParameters_[i])
                throw std::invalid_argument(fmt::format("{} is fixed at {}, outside of [{}, {}]", name,
                                                        fixed->second, prior.low, prior.high));
            fixedParameters_[i] = fixed->second;
            continue;
        }
        const bool isAsked =
            replaced != free.replacedPriors.end() || std::ranges::count(free.alsoFree, name) > 0;
        if (table[i].optional && !isAsked) continue;
        const double nyquist = 0.5 / settings_.FineGrid().Spacing();
        if (table[i].unit == "cycles/cm" && prior.high > nyquist && prior.low < nyquist) {
            warnings_.push_back(
                fmt::format("the prior of {} reaches to {:.4g} cycles/cm, and is cut at {:.4g}, beyond "
                            "which the photograph shows nothing",
                            name, prior.high, nyquist));
            prior.high = nyquist;
        }
        if ((name == "light" || name == "vig") && replaced == free.replacedPriors.end())
            scaled += (scaled.empty() ? "" : " and ") + name;
        freeIndices_.push_back(i);
        parameters.push_back({name, std::string(table[i].unit), prior, table[i].smooth, ScaleOf(name)});
    }
    if (settings_.distance != kPriorDistance && !scaled.empty())
        notes_.push_back(fmt::format("of {}: those for {} cm, scaled to {:.4g} cm", scaled, kPriorDistance,
                                     settings_.distance));
    return ParameterSpace(std::move(parameters));
}

PhotoSimulator::PhotoSimulator(const MaterialModel& model, const PhotoSettings& settings,
                               const FreeParameters& free, const std::vector<std::string>& families)
    : model_(model),
      settings_(Checked(settings)),
      families_(families.empty() ? DefaultSummaries(model) : families),
      space_(MakeSpace(free)) {
    const Lease first(*this);
    names_ = first->Names();
}
PhotoSimulator::~PhotoSimulator() = default;

std::vector<double> PhotoSimulator::AllParameters(const Vector& x) const {
    LACQUER_CHECK(size_t(x.size()) == freeIndices_.size());
    std::vector<double> all = fixedParameters_;
    for (size_t i = 0; i < freeIndices_.size(); ++i) all[freeIndices_[i]] = x[Eigen::Index(i)];
    return all;
}

Vector PhotoSimulator::Simulate(const Vector& x, uint64_t seed) const {
    const Lease workspace(*this);
    Vector values(Eigen::Index(names_.size()));
    workspace->Forward(AllParameters(x), seed, {values.data(), names_.size()});
    return values;
}

std::unique_ptr<DifferentiableRun> PhotoSimulator::SimulateForGradient(const Vector& x, uint64_t seed) const {
    return std::make_unique<Run>(*this, x, seed);
}

std::vector<FamilyRange> PhotoSimulator::FamilyRanges() const {
    std::vector<FamilyRange> ranges;
    Eigen::Index first = 0;
    for (const std::string& family : families_) {
        const auto count = Eigen::Index(SummarySet({family}, settings_.Grid(), settings_.vgg).Size());
        ranges.push_back({family, first, count});
        first += count;
    }
    return ranges;
}

Vector PhotoSimulator::SummariesOf(const PlanarImage& image) const {
    LACQUER_CHECK(image.size == settings_.resolution);
    SummarySet summaries(families_, settings_.Grid(), settings_.vgg);
    Vector values(Eigen::Index(names_.size()));
    PlanarImage seen = image;
    if (settings_.isRounded) RoundToBytes(&seen);
    summaries.Forward(std::move(seen), {values.data(), names_.size()});
    return values;
}

PlanarImage PhotoSimulator::Photograph(const Vector& x, uint64_t seed, Surface* surface) const {
    const Lease workspace(*this);
    std::vector<double> values(names_.size());
    workspace->Forward(AllParameters(x), seed, values);
    if (surface) *surface = workspace->LastSurface();
    return workspace->Image();
}

}  // namespace lacquer::estimate
