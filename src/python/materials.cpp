// Materials: values, densities, samples and energies for arrays of directions.
#include <fmt/format.h>
#include <pybind11/numpy.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>

#include "measure/bsdf_survey.h"
#include "measure/lobe_survey.h"
#include "measure/scene_material.h"
#include "measure/spectral_subject.h"
#include "pbrt/core/parallel.h"
#include "python/errors.h"
#include "python/interruptible.h"
#include "python/module.h"

namespace lacquer::python {

namespace py = pybind11;

namespace {

/// Rows of three, unit vectors: the package has normalised them.
using Directions = py::array_t<float, py::array::c_style | py::array::forcecast>;
using Doubles = py::array_t<double>;

/// How often to ask, of what.
struct Query {
    std::string mode = "radiance";
    int64_t samples = 1;
    uint64_t seed = 0;
    std::string estimator, layeredPdf;

    TransportMode Mode() const {
        return mode == "importance" ? TransportMode::Importance : TransportMode::Radiance;
    }
};

/// Checked views of arrays whose owners live on.
class DirectionView {
  public:
    explicit DirectionView(const Directions& array) : data_(array.data()), count_(array.shape(0)) {
        if (array.ndim() != 2 || array.shape(1) != 3)
            throw UsageError("expected rows of three numbers as directions");
    }
    int64_t Count() const { return count_; }
    Vec3 At(int64_t i) const { return {data_[3 * i], data_[3 * i + 1], data_[3 * i + 2]}; }

  private:
    const float* data_;
    int64_t count_;
};

void CheckPair(const DirectionView& a, const DirectionView& b) {
    if (a.Count() != b.Count()) throw UsageError("expected as many directions wi as wo");
}

void Store(glm::dvec3 value, double* row) {
    for (int c = 0; c < 3; ++c) row[c] = value[c];
}

/// Samples after which Ctrl-C is heard. A multiple of the draws of a mix, which they take in turn.
constexpr int64_t kSamplesInOneGo = 4096;

/// Runs body(i) for all rows in parallel, where Ctrl-C is heard unless it is over in an instant anyway. A
/// row's random numbers depend on the seed and on its index alone.
/// @param samples  of each row
void ForRows(int64_t count, int64_t samples, const std::function<void(int64_t, Observer&)>& body) {
    constexpr int64_t kSmallWork = 256;
    Notices notices;
    if (samples <= kSmallWork && count * samples <= kSmallWork) {
        const py::gil_scoped_release released;
        for (int64_t i = 0; i < count; ++i) body(i, notices);
        return;
    }
    RunInterruptibly(notices, py::none(), [&] {
        ParallelFor(count, [&](int64_t i) {
            if (!notices.ShouldStop()) body(i, notices);
        });
    });
}

/// add(number) until `samples` are taken, unless someone stops it.
template <class Add>
void InParts(int64_t samples, Observer& observer, const Add& add) {
    for (int64_t left = samples; left > 0 && !observer.ShouldStop(); left -= kSamplesInOneGo)
        add(std::min(left, kSamplesInOneGo));
}

/// A material of a scene. What it is built to depends on the estimator; each is built once.
class SurfaceMaterial {
  public:
    SurfaceMaterial(const ParsedScene& scene, std::string name, std::array<float, 2> uv,
                    const TextureFolders& textures)
        : name_(std::move(name)), uv_(uv[0], uv[1]), textures_(TextureMemoryOf(textures)) {
        auto description = *scene.description;
        // Nothing of this is needed, and the description is copied for each estimator.
        description.shapes.clear();
        description.objects.clear();
        description.instances.clear();
        description.lights.clear();
        description.areaLights.clear();
        description_ = std::move(description);
        Built({});
    }

    /// Errors: those of LoadMaterial(); UsageError for an estimator or a density where there is no choice.
    std::shared_ptr<const measure::SceneMaterial> Built(const Query& q) const {
        const py::gil_scoped_release released;
        const std::lock_guard lock(mutex_);
        auto& built = built_[{q.estimator, q.layeredPdf}];
        if (built) return built;
        const auto first = built_.find({"", ""});
        const bool isFirst = q.estimator.empty() && q.layeredPdf.empty();
        if (!isFirst && first != built_.end() && first->second && !measure::IsLayered(*first->second->bsdf))
            throw UsageError("an estimator and a density are for layered materials; this is a " + Type() +
                             ", whose value is exact");
        BuildOptions options;
        options.materials = {{"estimator", q.estimator}, {"pdf", q.layeredPdf}};
        options.textures = textures_;
        Notices notices;
        built = std::make_shared<measure::SceneMaterial>(
            measure::LoadMaterial(description_, name_, uv_, options, &notices));
        if (isFirst) {  // by the constructor, before others can ask
            type_ = built->setup.entity.type;
            warnings_ = notices.Warnings();
        }
        return built;
    }

    py::tuple Evaluate(const Directions& wo, const Directions& wi, const Query& q,
                       const std::vector<float>& wavelengths) const {
        const DirectionView o(wo), i(wi);
        CheckPair(o, i);
        const auto material = Built(q);
        const measure::BsdfSubject& bsdf = *material->bsdf;
        const size_t width = wavelengths.empty() ? 3 : wavelengths.size();
        Doubles values({size_t(o.Count()), width}), errors({size_t(o.Count()), width});
        double *value = values.mutable_data(), *error = errors.mutable_data();
        // A single value that is exact needs no repetition; a mix takes its parts in turn.
        const bool isExact = !bsdf.IsStochastic() && bsdf.NumVariants() == 1;
        const int64_t samples = isExact ? 1 : q.samples;
        std::unique_ptr<measure::SpectralSubject> spectral;
        if (!wavelengths.empty()) spectral = MakeSpectral(*material, wavelengths);
        ForRows(o.Count(), samples, [&](int64_t row, Observer& observer) {
            Rng rng(Hash(q.seed, 1, row));
            double *v = value + row * int64_t(width), *e = error + row * int64_t(width);
            if (spectral) {
                spectral->Evaluate(o.At(row), i.At(row), q.Mode(), samples, rng, {v, width}, {e, width},
                                   observer);
            } else {
                measure::ColorMean mean;
                InParts(samples, observer, [&](int64_t n) {
                    mean.Merge(bsdf.Evaluate(o.At(row), i.At(row), q.Mode(), n, rng));
                });
                Store(mean.Mean(), v);
                Store(samples > 1 ? mean.Error() : glm::dvec3(std::nan("")), e);
            }
            if (isExact) std::fill(e, e + width, 0.0);
        });
        return py::make_tuple(values, errors);
    }

    py::tuple Pdf(const Directions& wo, const Directions& wi, const Query& q) const {
        const DirectionView o(wo), i(wi);
        CheckPair(o, i);
        const auto material = Built(q);
        const measure::BsdfSubject& bsdf = *material->bsdf;
        Doubles values(o.Count()), errors(o.Count());
        double *value = values.mutable_data(), *error = errors.mutable_data();
        const bool isExact = !bsdf.IsStochastic() && bsdf.NumVariants() == 1;
        const int64_t samples = isExact ? 1 : q.samples;
        ForRows(o.Count(), samples, [&](int64_t row, Observer& observer) {
            Rng rng(Hash(q.seed, 2, row));
            measure::ColorMean mean;
            const auto add = [&](int64_t batch) {
                double sum = 0;
                for (int64_t set = 0; set < kSets; ++set)
                    sum += double(bsdf.At(batch * kSets + set)
                                      .Pdf(o.At(row), i.At(row), {.mode = q.Mode(), .rng = &rng}));
                mean.Add(glm::dvec3(sum / double(kSets)));
            };
            InParts(samples, observer, [&](int64_t n) {
                for (int64_t batch = 0; batch < n; ++batch) add(batch);
            });
            value[row] = mean.Mean().x;
            error[row] = isExact ? 0 : samples > 1 ? mean.Error().x : std::nan("");
        });
        return py::make_tuple(values, errors);
    }

    /// wi, weight, density, lobe; zeros for a draw that failed.
    py::tuple Sample(const Directions& wo, const Query& q, const std::vector<float>& wavelengths) const {
        const DirectionView o(wo);
        const auto material = Built(q);
        const measure::BsdfSubject& bsdf = *material->bsdf;
        const size_t width = wavelengths.empty() ? 3 : wavelengths.size();
        std::unique_ptr<measure::SpectralSubject> spectral;
        if (!wavelengths.empty()) {
            spectral = MakeSpectral(*material, wavelengths);
            if (!spectral->Together(0))
                throw UsageError(fmt::format(
                    "sample() follows one path: ask for at most {} wavelengths, and for one where "
                    "the material disperses",
                    kNumWavelengths));
        }
        const auto rows = size_t(o.Count());
        Doubles wis({rows, size_t(3)}), weights({rows, width}), pdfs(o.Count());
        py::array_t<unsigned> lobes(o.Count());
        double *wi = wis.mutable_data(), *weight = weights.mutable_data(), *pdf = pdfs.mutable_data();
        unsigned* lobe = lobes.mutable_data();
        ForRows(o.Count(), 1, [&](int64_t row, Observer& /*observer*/) {
            Rng rng(Hash(q.seed, 3, row));
            const BxDF& bxdf = spectral ? *spectral->Together(row) : bsdf.At(row);
            const float u = rng.Uniform();
            const auto drawn = bxdf.Sample(o.At(row), {u, rng.Uniform2D()}, {.mode = q.Mode(), .rng = &rng});
            double* w = weight + row * int64_t(width);
            std::fill(w, w + width, 0.0);
            Store(drawn ? glm::dvec3(drawn->wi) : glm::dvec3(0), wi + 3 * row);
            pdf[row] = drawn ? double(drawn->pdf) : 0;
            lobe[row] = drawn ? unsigned(drawn->lobe) : 0;
            if (!drawn) return;
            if (!spectral) Store(glm::dvec3(bsdf.ToRGB(drawn->weight, row)), w);
            for (size_t lane = 0; spectral && lane < width; ++lane)
                w[lane] = double(drawn->weight[int(lane)]);
        });
        return py::make_tuple(wis, weights, pdfs, lobes);
    }

    /// Reflected and transmitted, each with its error, by following samples.
    py::tuple Energy(const Directions& w, const Query& q) const {
        const DirectionView directions(w);
        const auto material = Built(q);
        const auto rows = size_t(directions.Count());
        Doubles parts[4];
        double* out[4];
        for (int k = 0; k < 4; ++k) {
            parts[k] = Doubles({rows, size_t(3)});
            out[k] = parts[k].mutable_data();
        }
        Notices notices;
        RunInterruptibly(notices, py::none(), [&] {
            for (int64_t row = 0; row < directions.Count() && !notices.ShouldStop(); ++row) {
                measure::ColorMean reflected, transmitted;
                uint64_t part = 0;
                InParts(q.samples, notices, [&](int64_t n) {
                    const measure::LobeQuery query{*material->bsdf, directions.At(row), q.Mode(),
                                                   Hash(q.seed, 4, row, part++), nullptr};
                    const measure::SampledLobe lobe = measure::SampleLobe(query, n);
                    reflected.Merge(lobe.reflected);
                    transmitted.Merge(lobe.transmitted);
                });
                const glm::dvec3 unknown(std::nan(""));
                Store(reflected.Mean(), out[0] + 3 * row);
                Store(q.samples > 1 ? reflected.Error() : unknown, out[1] + 3 * row);
                Store(transmitted.Mean(), out[2] + 3 * row);
                Store(q.samples > 1 ? transmitted.Error() : unknown, out[3] + 3 * row);
            }
        });
        return py::make_tuple(parts[0], parts[1], parts[2], parts[3]);
    }

    std::string Type() const { return type_; }
    std::vector<std::string> Warnings() const { return warnings_; }
    bool IsStochastic() const { return Built({})->bsdf->IsStochastic(); }

  private:
    static constexpr int64_t kSets = measure::BsdfSubject::kNumSets;

    std::unique_ptr<measure::SpectralSubject> MakeSpectral(const measure::SceneMaterial& material,
                                                           const std::vector<float>& wavelengths) const {
        const py::gil_scoped_release released;
        return std::make_unique<measure::SpectralSubject>(*material.setup.material, uv_, wavelengths,
                                                          material.setup.entity.loc);
    }

    SceneDescription description_;
    std::string name_;
    Point2 uv_;
    TextureMemory textures_;
    mutable std::mutex mutex_;
    mutable std::map<std::pair<std::string, std::string>, std::shared_ptr<const measure::SceneMaterial>>
        built_;
    mutable std::string type_;
    mutable std::vector<std::string> warnings_;
};

}  // namespace

void DefineMaterials(py::module_& m) {
    py::class_<Query>(m, "Query")
        .def(py::init<>())
        .def_readwrite("mode", &Query::mode)
        .def_readwrite("samples", &Query::samples)
        .def_readwrite("seed", &Query::seed)
        .def_readwrite("estimator", &Query::estimator)
        .def_readwrite("layered_pdf", &Query::layeredPdf);
    py::class_<SurfaceMaterial>(m, "SurfaceMaterial")
        .def(py::init<const ParsedScene&, std::string, std::array<float, 2>, const TextureFolders&>(),
             py::arg("scene"), py::arg("name"), py::arg("uv"), py::arg("textures"))
        .def("evaluate", &SurfaceMaterial::Evaluate)
        .def("pdf", &SurfaceMaterial::Pdf)
        .def("sample", &SurfaceMaterial::Sample)
        .def("energy", &SurfaceMaterial::Energy)
        .def("type", &SurfaceMaterial::Type)
        .def("warnings", &SurfaceMaterial::Warnings)
        .def("is_stochastic", &SurfaceMaterial::IsStochastic);
}

}  // namespace lacquer::python
