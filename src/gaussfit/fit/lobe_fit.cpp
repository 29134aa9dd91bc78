#include "gaussfit/fit/lobe_fit.h"

#include <fmt/format.h>

#include <cmath>

#include "gaussfit/fit/polynomial_fit.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"

namespace lacquer::gaussfit {

namespace {

double RadiansOf(double degrees) { return degrees * (3.14159265358979323846 / 180); }

/// Position k of n between 0 and 1.
double Step(int k, int n) { return n > 1 ? double(k) / (n - 1) : 0; }

LobeQuery<double> QueryAt(const SlicePoint& point) { return {point.alpha, point.eta, std::cos(point.theta)}; }

/// The fit of one patch of a table: the slices, the basis at their points, and the polynomials so far.
class PatchFit {
  public:
    PatchFit(const LobeTable::Content& content, const LobePatch& patch, const LobeFitOptions& options,
             std::vector<SliceFit> slices)
        : model_(*content.model), options_(options), slices_(std::move(slices)), patch_(patch) {
        BuildBasis(content);
        BuildNeighbors(content.EtaDegree());
        control_.assign(size_t(NumFields()), std::vector<double>(size_t(basis_.columns), 1.0));
        for (const SliceFit& fit : slices_) targets_.push_back(fit.best);
        means_.resize(slices_.size());
    }

    int NumFields() const { return model_.numComponents * LobePatch::kFields; }

    /// Fits one field to the targets. Means must come first: what they miss widens the lobes.
    void FitField(int field) {
        const int part = field / LobePatch::kFields, kind = field % LobePatch::kFields;
        std::vector<double>& control = control_[size_t(field)];
        if (kind == LobePatch::Weight && part + 1 == model_.numComponents) {
            control.assign(control.size(), 0);  // the rest of the others
            return;
        }
        PolynomialFitProblem problem;
        problem.basis = &basis_;
        problem.smoothing = options_.smoothing * std::sqrt(double(slices_.size()));
        problem.neighbors = neighbors_;
        for (size_t i = 0; i < slices_.size(); ++i) SetTarget(i, part, kind, &problem);
        if (kind == LobePatch::L11 || kind == LobePatch::L22) {
            problem.isLogarithmic = true;
            problem.lower = 1e-4;
        } else if (kind == LobePatch::Weight) {
            problem.lower = 0.01;
            problem.upper = 0.99;
        }
        FitPolynomial(problem, &control);
    }

    /// Remembers what the fitted means are, for the fits of L.
    void UpdateMeans() {
        for (size_t i = 0; i < slices_.size(); ++i)
            for (int part = 0; part < model_.numComponents; ++part)
                means_[i][size_t(part)] =
                    shapes_[i].mean * Value(int(i), part * LobePatch::kFields + LobePatch::Mean);
    }

    /// New targets for one slice: it is shared out to the mixture as fitted so far.
    void Retarget(size_t i) { targets_[i] = ShareOut(slices_[i].slice, Fitted(i)); }

    SliceMixture Fitted(size_t i) const {
        SliceMixture mixture;
        mixture.count = model_.numComponents;
        double rest = 1;
        for (int part = 0; part < mixture.count; ++part) {
            const int field = part * LobePatch::kFields;
            SliceGaussian& g = mixture.parts[size_t(part)];
            g.meanX = shapes_[i].mean * Value(int(i), field + LobePatch::Mean);
            g.varianceX = std::pow(shapes_[i].l11 * Value(int(i), field + LobePatch::L11), -2);
            g.varianceY = std::pow(shapes_[i].l22 * Value(int(i), field + LobePatch::L22), -2);
            g.weight = part + 1 == mixture.count ? rest : Value(int(i), field + LobePatch::Weight);
            rest -= g.weight;
        }
        return mixture;
    }

    size_t NumSlices() const { return slices_.size(); }
    const SliceFit& At(size_t i) const { return slices_[i]; }

    LobePatch Result() const {
        LobePatch result = patch_;
        for (int i = 0; i < basis_.columns; ++i)
            for (int field = 0; field < NumFields(); ++field)
                result.control.push_back(float(control_[size_t(field)][size_t(i)]));
        return result;
    }

  private:
    void BuildBasis(const LobeTable::Content& content) {
        const LobeMap<double> map(content.DomainOf(patch_));
        basis_.columns = content.NumControlPoints();
        for (const SliceFit& fit : slices_) {
            const LobeQuery<double> query = QueryAt(fit.point);
            const LobeBasis<double> basis = LobeBasisOf(model_.event, query);
            shapes_.push_back(basis.shape);
            const LobeCoordinates<double> at = map(query, basis);
            auto byEta = BernsteinBasis<kLobeEtaDegree>(at.eta);
            if (content.EtaDegree() == 0) byEta[0] = 1;
            const auto byAlpha = BernsteinBasis<kLobeAlphaDegree>(at.alpha);
            const auto byTheta = BernsteinBasis<kLobeThetaDegree>(at.theta);
            for (int i = 0; i <= content.EtaDegree(); ++i)
                for (const double alphaValue : byAlpha)
                    for (const double thetaValue : byTheta)
                        basis_.values.push_back(byEta[size_t(i)] * alphaValue * thetaValue);
        }
    }

    void BuildNeighbors(int etaDegree) {
        const auto index = [](int i, int j, int k) {
            return (i * (kLobeAlphaDegree + 1) + j) * (kLobeThetaDegree + 1) + k;
        };
        for (int i = 0; i <= etaDegree; ++i)
            for (int j = 0; j <= kLobeAlphaDegree; ++j)
                for (int k = 0; k <= kLobeThetaDegree; ++k) {
                    if (i > 0) neighbors_.push_back({index(i - 1, j, k), index(i, j, k)});
                    if (j > 0) neighbors_.push_back({index(i, j - 1, k), index(i, j, k)});
                    if (k > 0) neighbors_.push_back({index(i, j, k - 1), index(i, j, k)});
                }
    }

    /// Target and weight of one slice. The weights are the roots of what an error costs in log-likelihood
    /// (Fisher's information), so that the sum of all squares is the likelihood that is lost, to second
    /// order.
    void SetTarget(size_t i, int part, int kind, PolynomialFitProblem* problem) const {
        const SliceGaussian& g = targets_[i].parts[size_t(part)];
        const LobeShape<double>& shape = shapes_[i];
        double target = 1, weight = 0;
        const double share = std::sqrt(std::max(0.0, g.weight));
        if (kind == LobePatch::Mean) {
            // At normal incidence the mean is 0 whatever the factor.
            if (std::abs(shape.mean) > 0) target = g.meanX / shape.mean;
            weight = share * std::abs(shape.mean) / std::sqrt(g.varianceX);
            if (!std::isfinite(target) || weight < 1e-9) target = 1, weight = 0;
        } else if (kind == LobePatch::L11) {
            // The best width around a mean that is not quite right.
            const double miss = means_[i][size_t(part)] - g.meanX;
            target = -0.5 * std::log(g.varianceX + miss * miss) - std::log(shape.l11);
            weight = share * std::sqrt(2.0);
        } else if (kind == LobePatch::L22) {
            target = -0.5 * std::log(g.varianceY) - std::log(shape.l22);
            weight = share * std::sqrt(2.0);
        } else {
            target = g.weight;
            weight = 1 / std::sqrt(std::max(1e-4, g.weight * (1 - g.weight)));
        }
        problem->targets.push_back(target);
        problem->weights.push_back(weight);
    }

    double Value(int row, int field) const {
        const double* basis = basis_.Row(row);
        double sum = 0;
        for (int k = 0; k < basis_.columns; ++k) sum += basis[k] * control_[size_t(field)][size_t(k)];
        return sum;
    }

    const LobeModel& model_;
    const LobeFitOptions& options_;
    std::vector<SliceFit> slices_;
    LobePatch patch_;
    BasisMatrix basis_;
    std::vector<std::array<int, 2>> neighbors_;
    std::vector<LobeShape<double>> shapes_;  // of the slices, without factors
    std::vector<SliceMixture> targets_;      // of the slices
    std::vector<std::array<double, LobeTable::kMaxComponents>> means_;
    std::vector<std::vector<double>> control_;  // of the fields
};

std::vector<SlicePoint> TrainingPoints(const LobeModel& model, const LobeFitOptions& o, int patch) {
    std::vector<SlicePoint> points;
    const int etas = model.Transmits() ? o.etas : 1;
    for (int i = 0; i < etas; ++i)
        for (int j = 0; j < o.alphas; ++j)
            for (int k = 0; k < o.thetas; ++k)
                points.push_back(
                    PointAt(model, o, patch, Step(i, etas), Step(j, o.alphas), Step(k, o.thetas)));
    return points;
}

void StopIfAsked(Observer* observer) {
    if (observer->ShouldStop()) throw FitStopped();
}

std::vector<SliceFit> TrainingSlices(const LobeModel& model, const LobeFitOptions& options, int patch,
                                     Observer* observer) {
    const std::vector<SlicePoint> points = TrainingPoints(model, options, patch);
    std::vector<SliceFit> slices(points.size());
    ParallelFor(int64_t(points.size()), [&](int64_t i) {
        StopIfAsked(observer);
        slices[size_t(i)] = FitSliceAt(model, points[size_t(i)], options);
        observer->Advance(1);
    });
    std::erase_if(slices, [](const SliceFit& fit) { return fit.slice.IsEmpty(); });
    return slices;
}

LobeTable::Content EmptyContent(const LobeModel& model, const LobeFitOptions& o) {
    LobeTable::Content c;
    c.model = &model;
    if (model.Transmits()) {
        c.etaMin = o.etaMin;
        c.etaMax = o.etaMax;
    }
    c.grazingCosineMin = model.event == LobeEvent::Leaving ? std::sqrt(1 - o.maxSine * o.maxSine)
                                                           : std::cos(RadiansOf(o.maxThetaDeg));
    const auto add = [&](const char* name, const std::string& value) { c.options.emplace_back(name, value); };
    add("slices", fmt::format("{} eta x {} alpha x {} theta in each of 2 patches",
                              model.Transmits() ? o.etas : 1, o.alphas, o.thetas));
    add("grid",
        fmt::format("{} x {} cells, truncation {}", o.slice.columns, o.slice.rows, o.slice.truncation));
    add("mixture-steps", fmt::format("{}", model.numComponents > 1 ? o.mixtureSteps : 1));
    add("rounds", fmt::format("{}", o.rounds));
    add("smoothing", fmt::format("{}", o.smoothing));
    return c;
}

void FitFields(std::vector<PatchFit>& patches, int kindBegin, int kindEnd, int64_t progress,
               Observer* observer) {
    struct Task {
        PatchFit* patch;
        int field;
    };
    std::vector<Task> tasks;
    for (PatchFit& patch : patches)
        for (int field = 0; field < patch.NumFields(); ++field)
            if (field % LobePatch::kFields >= kindBegin && field % LobePatch::kFields < kindEnd)
                tasks.push_back({&patch, field});
    ParallelFor(int64_t(tasks.size()), [&](int64_t i) {
        StopIfAsked(observer);
        tasks[size_t(i)].patch->FitField(tasks[size_t(i)].field);
        observer->Advance(progress);
    });
}

/// Fits all fields of all patches to their targets. @param progress  of one polynomial
void Round(std::vector<PatchFit>& patches, int64_t progress, Observer* observer) {
    FitFields(patches, LobePatch::Mean, LobePatch::Mean + 1, progress, observer);
    for (PatchFit& patch : patches) patch.UpdateMeans();
    FitFields(patches, LobePatch::L11, LobePatch::kFields, progress, observer);
}

}  // namespace

SlicePoint PointAt(const LobeModel& model, const LobeFitOptions& o, int patch, double eta, double alpha,
                   double theta) {
    const auto between = [](double a, double b, double t) { return a + t * (b - a); };
    SlicePoint point;
    const double a0 = std::sqrt(patch == 0 ? o.alphaMin : o.alphaSplit);
    const double a1 = std::sqrt(patch == 0 ? o.alphaSplit : o.alphaMax);
    point.alpha = std::pow(between(a0, a1, alpha), 2);
    // Denser towards the end, where slices change fastest.
    const double position = 1 - std::pow(1 - theta, 1.5);
    if (!model.Transmits()) {
        point.theta = RadiansOf(o.maxThetaDeg) * position;
        return point;
    }
    const double index = 1 + std::pow(between(std::sqrt(o.etaMin - 1), std::sqrt(o.etaMax - 1), eta), 2);
    if (model.event == LobeEvent::Entering) {
        point.eta = index;
        point.theta = RadiansOf(o.maxThetaDeg) * position;
    } else {
        point.eta = 1 / index;
        // By the refracted angle: near the critical angle it changes much faster than theta.
        point.theta = std::asin(std::sin(std::asin(o.maxSine) * position) / index);
    }
    return point;
}

SliceFit FitSliceAt(const LobeModel& model, const SlicePoint& point, const LobeFitOptions& options) {
    SliceFit fit;
    fit.point = point;
    fit.slice = TabulateSlice(model, point, options.slice);
    if (!fit.slice.IsEmpty()) fit.best = FitSlice(fit.slice, model.numComponents, options.mixtureSteps);
    return fit;
}

LobeError ErrorOf(const SliceFit& fit, const SliceMixture& fitted) {
    // Moments of whole mixtures: parts may trade among each other.
    const auto moments = [](const SliceMixture& m) {
        SliceMoments all;
        for (int i = 0; i < m.count; ++i) {
            const SliceGaussian& g = m.parts[size_t(i)];
            all.meanX += g.weight * g.meanX;
            all.varianceX += g.weight * (g.varianceX + g.meanX * g.meanX);
            all.varianceY += g.weight * g.varianceY;
        }
        all.varianceX -= all.meanX * all.meanX;
        return all;
    };
    const SliceMoments a = moments(fit.best), b = moments(fitted);
    LobeError error;
    error.meanInSigmas = std::abs(b.meanX - a.meanX) / std::sqrt(a.varianceX);
    error.logL11 = 0.5 * std::abs(std::log(b.varianceX / a.varianceX));
    error.logL22 = 0.5 * std::abs(std::log(b.varianceY / a.varianceY));
    error.lostLikelihood = LogLikelihood(fit.slice, fit.best) - LogLikelihood(fit.slice, fitted);
    error.uncovered = 1 - Overlap(fit.slice, fitted);
    return error;
}

LobeErrorSummary Summarize(const std::vector<LobeError>& errors) {
    LobeErrorSummary s;
    s.count = int(errors.size());
    const auto visit = [&](double LobeError::*field) {
        double squares = 0, max = 0;
        for (const LobeError& e : errors) {
            squares += e.*field * (e.*field);
            max = std::max(max, e.*field);
        }
        s.rms.*field = errors.empty() ? 0 : std::sqrt(squares / double(errors.size()));
        s.max.*field = max;
    };
    visit(&LobeError::meanInSigmas);
    visit(&LobeError::logL11);
    visit(&LobeError::logL22);
    visit(&LobeError::lostLikelihood);
    visit(&LobeError::uncovered);
    return s;
}

LobeFitResult FitLobes(const LobeModel& model, const LobeFitOptions& options, Observer* observer) {
    const Clock::time_point start = Clock::now();
    LobeTable::Content content = EmptyContent(model, options);

    // Slices, and the best mixture of each. The unit of progress is a slice; a polynomial counts as much as
    // its share of the time is.
    std::vector<PatchFit> patches;
    const int64_t numSlices = 2 * int64_t(TrainingPoints(model, options, 0).size());
    const int64_t numPolynomials =
        int64_t(2) * model.numComponents * LobePatch::kFields * (options.rounds + 1);
    const int64_t perPolynomial = std::max<int64_t>(1, numSlices / (2 * numPolynomials));
    observer->Begin(model.name, numSlices + numPolynomials * perPolynomial, "");
    for (int i = 0; i < 2; ++i) {
        LobePatch patch;
        patch.alphaMin = i == 0 ? options.alphaMin : options.alphaSplit;
        patch.alphaMax = i == 0 ? options.alphaSplit : options.alphaMax;
        patch.anglesBySpread = i == 0;
        patches.emplace_back(content, patch, options, TrainingSlices(model, options, i, observer));
    }
    const double sliceSeconds = SecondsSince(start);

    // Polynomials through them.
    Round(patches, perPolynomial, observer);
    for (int round = 0; round < options.rounds; ++round) {
        for (PatchFit& patch : patches)
            ParallelFor(int64_t(patch.NumSlices()), [&](int64_t i) { patch.Retarget(size_t(i)); });
        Round(patches, perPolynomial, observer);
    }
    for (const PatchFit& patch : patches) content.patches.push_back(patch.Result());
    LobeTable table(std::move(content), fmt::format("{}.txt", model.name));
    const double fitSeconds = SecondsSince(start) - sliceSeconds;

    std::vector<LobeError> errors;
    for (const PatchFit& patch : patches)
        for (size_t i = 0; i < patch.NumSlices(); ++i)
            errors.push_back(ErrorOf(patch.At(i), MixtureOf(table, patch.At(i).point)));
    observer->End();
    return {std::move(table), Summarize(errors), sliceSeconds, fitSeconds};
}

LobeSurvey SurveyTable(const LobeTable& table, const LobeFitOptions& options, int etas, int alphas,
                       int angles) {
    const LobeModel& model = *table.Get().model;
    const auto middle = [](int k, int n) { return (k + 0.5) / n; };
    LobeSurvey survey;
    if (!model.Transmits()) etas = 1;
    for (int i = 0; i < etas; ++i)
        survey.etas.push_back(model.Transmits() ? PointAt(model, options, 0, Step(i, etas), 0, 0).eta : 1);
    for (int i = 0; i < alphas; ++i)  // even steps of log alpha
        survey.alphas.push_back(options.alphaMin *
                                std::pow(options.alphaMax / options.alphaMin, middle(i, alphas)));
    for (int i = 0; i < angles; ++i) survey.angles.push_back(Step(i, angles));

    survey.fits.resize(survey.etas.size() * survey.alphas.size() * survey.angles.size());
    survey.errors.resize(survey.fits.size());
    ParallelFor(int64_t(survey.fits.size()), [&](int64_t i) {
        const size_t angle = size_t(i) % survey.angles.size(), rest = size_t(i) / survey.angles.size();
        SlicePoint point =
            PointAt(model, options, 0, Step(int(rest / survey.alphas.size()), etas), 0, survey.angles[angle]);
        point.alpha = survey.alphas[rest % survey.alphas.size()];
        SliceFit fit = FitSliceAt(model, point, options);
        if (!fit.slice.IsEmpty()) survey.errors[size_t(i)] = ErrorOf(fit, MixtureOf(table, point));
        survey.fits[size_t(i)] = std::move(fit);
    });
    return survey;
}

}  // namespace lacquer::gaussfit
