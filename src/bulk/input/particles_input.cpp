#include "bulk/input/particles_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "bulk/input/material_index.h"
#include "bulk/input/particle_list.h"
#include "bulk/input/particles_json.h"
#include "bulk/table/bulk_problem.h"
#include "pbrt/core/file_bytes.h"

namespace lacquer::bulk {
namespace {

const std::vector<std::string> kKeys = {"wavelengths", "host",   "species", "arrangement",
                                        "method",      "length", "seed",    "sizes"};
const std::vector<std::string> kSpeciesKeys = {"name", "index", "radius", "volume fraction"};
const std::vector<std::string> kRadiusKeys = {"lognormal", "normal", "table"};

const Choices<double> kLengths = {{"um", 1}, {"nm", 1e-3}, {"mm", 1e3}};
const Choices<BulkMethod> kMethods = {{"clusters", BulkMethod::Clusters},
                                      {"independent", BulkMethod::Independent},
                                      {"structure", BulkMethod::Structure}};
const Choices<AverageMode> kModes = {{"medium", AverageMode::Medium},
                                     {"aggregate", AverageMode::Aggregate},
                                     {"chapter", AverageMode::Chapter}};
const Choices<Arrangement> kArrangements = {
    {"uniform", Arrangement::Uniform},   {"cut", Arrangement::Cut},
    {"clumped", Arrangement::Clumped},   {"poisson-disc", Arrangement::PoissonDisc},
    {"gaussian", Arrangement::Gaussian}, {"disc", Arrangement::Gaussian},
    {"list", Arrangement::List}};

/// The largest volume fraction at which the generator finds places, and how it looks for them.
struct Packing {
    double highest;
    const char* how;
};
Packing PackingOf(const EnsembleSettings& ensemble) {
    constexpr double kSequential = 0.25, kMonteCarlo = 0.5, kClosePacked = 0.74;
    switch (ensemble.arrangement) {
        case Arrangement::Uniform:
        case Arrangement::Cut:
            return {kMonteCarlo, "hard spheres are moved at random (Monte Carlo) up to"};
        case Arrangement::Clumped:
            return {kSequential, "children are put beside parents, one after another, up to"};
        case Arrangement::PoissonDisc:
            return {kSequential / std::pow(ensemble.minDistance, 3),
                    "spheres this far apart are put one after another up to"};
        case Arrangement::Gaussian:
        case Arrangement::List:
            break;
    }
    return {kClosePacked, "spheres are packed most closely at"};
}

class ParticlesReader : ParticlesJson {
  public:
    ParticlesReader(std::string_view text, const std::string& path, const ParticlesOverrides& overrides)
        : ParticlesJson(text, path), overrides_(overrides) {}

    ParticlesInput Read() {
        CheckKeys("", kKeys);
        if (Has("/length")) SetUnit(Choice("/length", kLengths));
        if (Has("/method")) s_.method = Choice("/method", kMethods);
        if (overrides_.seed)
            s_.seed = *overrides_.seed;
        else if (Has("/seed"))
            s_.seed = uint64_t(Whole("/seed", 0, 0x1p53));
        ReadWavelengths();
        ReadHost();
        ReadSpecies();
        ReadArrangement();
        CheckFractions();
        ReadSizes();
        if (s_.method == BulkMethod::Clusters) CheckBalls();
        input_.json = Root().dump();
        return std::move(input_);
    }

  private:
    EnsembleSettings& Ensemble() { return s_.ensemble; }

    // ---- Wavelengths and indices ----

    void ReadWavelengths() {
        const char* kExpected = "a number, a growing list, or begin, end and step [nm]";
        const std::string at = "/wavelengths";
        if (!overrides_.wavelengths.empty()) {
            s_.wavelengths = overrides_.wavelengths;
            return;
        }
        if (At(at).is_number()) {
            s_.wavelengths = {Number(at, 1, 1e6)};
            return;
        }
        if (!At(at).is_array() || At(at).empty())
            Fail(at, fmt::format("found {}; expected {}", KindOf(At(at)), kExpected));
        const std::vector<double> numbers = Numbers(at, {}, 1e-3, 1e6);
        if (numbers.size() == 3 && numbers[2] <= numbers[1]) {
            s_.wavelengths = EvenWavelengths(numbers[0], numbers[1], numbers[2]);
            if (s_.wavelengths.empty())
                Fail(at, fmt::format("from {} to {} by {}: expected {}, at most {} of them in [1, 1e6] nm",
                                     numbers[0], numbers[1], numbers[2], kExpected, kMaxWavelengths));
            return;
        }
        s_.wavelengths = Numbers(at, {}, 1, 1e6);
        if (numbers.size() > size_t(kMaxWavelengths))
            Fail(at, fmt::format("this list has {} numbers; expected at most {}", numbers.size(),
                                 kMaxWavelengths));
        constexpr double kStepNm = 1e-3;  // as tables have it
        RequireGrowing(at, s_.wavelengths, kStepNm);
    }

    void ReadHost() {
        CheckKeys("/host", {"index"});
        const Json& index = At("/host/index");
        if (index.is_array() && index.size() == 2 && index[1] != 0)
            Fail("/host/index/1",
                 fmt::format("found {}; expected 0: cross sections are those of particles in a host that "
                             "does not absorb",
                             KindOf(index[1])));
        const std::string at = index.is_array() && index.size() == 2 ? "/host/index/0" : "/host/index";
        s_.hostIndex = Number(at, At(at), 0.1, 10);
    }

    /// A complex index, [n, k].
    Complex ComplexAt(const std::string& nAt, const std::string& kAt) const {
        const double n = Number(nAt, 0, 100), k = kAt.empty() ? 0 : Number(kAt, -kInf, kInf);
        if (k < 0)
            Fail(kAt, fmt::format("found {}; expected at least 0: with the time factor exp(-iwt) absorption "
                                  "is a positive imaginary part",
                                  KindOf(At(kAt))));
        if (k > 100) Fail(kAt, fmt::format("found {}; expected a number in [0, 100]", KindOf(At(kAt))));
        if (n + k < 0.01)
            Fail(nAt, fmt::format("found {}; expected an index of refraction", KindOf(At(nAt))));
        return {n, k};
    }
    OpticalIndex ReadIndex(const std::string& at) const {
        const Json& value = At(at);
        if (value.is_number()) return OpticalIndex(ComplexAt(at, ""));
        if (value.is_string()) {
            const auto index = NamedIndex(value.get<std::string>(), s_.wavelengths);
            if (!index)
                Fail(at, fmt::format("unknown material {}{}", KindOf(value),
                                     DidYouMean(value.get<std::string>(), NamedIndices())));
            CheckCovers(at, kNamedIndexFirst, kNamedIndexLast);
            return *index;
        }
        if (value.is_object()) return ReadIndexTable(at);
        if (!value.is_array() || value.size() != 2)
            Fail(at, fmt::format("found {}; expected an index of refraction: a number, [n, k], the name of a "
                                 "material, or an object of wavelengths, n and k",
                                 KindOf(value)));
        return OpticalIndex(ComplexAt(at + "/0", at + "/1"));
    }
    OpticalIndex ReadIndexTable(const std::string& at) const {
        CheckKeys(at, {"wavelengths", "n", "k"});
        const std::vector<double> wavelengths = Numbers(at + "/wavelengths", {}, 1, 1e6);
        if (wavelengths.empty()) Fail(at + "/wavelengths", "this list is empty; expected wavelengths [nm]");
        RequireGrowing(at + "/wavelengths", wavelengths, 1e-3);
        const Length length{wavelengths.size(), "one for each wavelength"};
        const bool hasK = Has(at + "/k");
        Numbers(at + "/n", length, 0, 100);
        if (hasK) Numbers(at + "/k", length, -kInf, kInf);
        std::vector<OpticalIndex::Node> nodes;
        for (size_t i = 0; i < wavelengths.size(); ++i)
            nodes.push_back({wavelengths[i], ComplexAt(fmt::format("{}/n/{}", at, i),
                                                       hasK ? fmt::format("{}/k/{}", at, i) : "")});
        CheckCovers(at + "/wavelengths", wavelengths.front(), wavelengths.back());
        return OpticalIndex(std::move(nodes));
    }
    void CheckCovers(const std::string& at, double first, double last) const {
        for (const double wavelength : s_.wavelengths)
            if (wavelength < first || wavelength > last)
                Fail(at, fmt::format("this index is known from {:g} to {:g} nm; {:g} nm is asked for", first,
                                     last, wavelength));
    }

    // ---- Species ----

    void ReadSpecies() {
        const size_t count = NumItems("/species", "a list of one species or several");
        for (size_t i = 0; i < count; ++i) {
            const std::string at = fmt::format("/species/{}", i);
            CheckKeys(at, kSpeciesKeys);
            Species species;
            species.name = fmt::format("species {}", i + 1);
            if (Has(at + "/name")) {
                if (!At(at + "/name").is_string())
                    Fail(at + "/name", fmt::format("found {}; expected a name", KindOf(At(at + "/name"))));
                species.name = At(at + "/name").get<std::string>();
            }
            for (const Species& other : Ensemble().species)
                if (other.name == species.name)
                    Fail(at + "/name", fmt::format("there is a species \"{}\" before this one; expected "
                                                   "another name",
                                                   Excerpt(species.name)));
            species.radius = ReadRadius(at + "/radius");
            species.volumeFraction =
                Positive(at + "/volume fraction", 1, "a part of the volume, above 0 and at most 1");
            s_.indices.push_back(ReadIndex(at + "/index"));
            Ensemble().species.push_back(std::move(species));
            CheckSize(at + "/radius", s_, Ensemble().species.back().radius.Largest());
            CheckContrast(at + "/index", s_.indices.back());
        }
    }

    RadiusDistribution ReadRadius(const std::string& at) const {
        if (!At(at).is_object()) return RadiusDistribution::Constant(Radius(at));
        CheckKeys(at, kRadiusKeys);
        if (At(at).size() != 1)
            Fail(at, "expected a number, or an object with one of lognormal, normal and table");
        constexpr double kMaxSigma = 2;
        if (Has(at + "/lognormal")) {
            CheckKeys(at + "/lognormal", {"median", "sigma"});
            return RadiusDistribution::LogNormal(Radius(at + "/lognormal/median"),
                                                 Number(at + "/lognormal/sigma", 0, kMaxSigma));
        }
        if (Has(at + "/normal")) {
            CheckKeys(at + "/normal", {"mean", "sigma"});
            const double mean = Radius(at + "/normal/mean");
            return RadiusDistribution::Normal(
                mean, Unit() * Number(at + "/normal/sigma", 0, kMaxSigma * mean / Unit()));
        }
        const std::string table = at + "/table";
        CheckKeys(table, {"radii", "weights"});
        const size_t count = NumItems(table + "/radii", "a list of radii");
        constexpr size_t kMaxRadii = 1000;
        if (count > kMaxRadii)
            Fail(table + "/radii",
                 fmt::format("this list has {} numbers; expected at most {}", count, kMaxRadii));
        const std::vector<double> weights =
            Numbers(table + "/weights", Length{count, "one for each radius"}, 0, 1e100);
        std::vector<RadiusDistribution::Node> nodes;
        double sum = 0;
        for (size_t i = 0; i < count; ++i) {
            nodes.push_back({Radius(fmt::format("{}/radii/{}", table, i)), weights[i]});
            sum += weights[i];
        }
        if (!(sum > 0)) Fail(table + "/weights", "all weights are 0; expected numbers of particles");
        return RadiusDistribution::Table(std::move(nodes));
    }

    void CheckContrast(const std::string& at, const OpticalIndex& index) const {
        for (const double wavelength : s_.wavelengths)
            if (std::abs(index.At(wavelength) / s_.hostIndex - 1.) < 1e-6)
                Fail(at, fmt::format("at {:g} nm this is the index of the host, {:g}; such "
                                     "particles scatter nothing",
                                     wavelength, s_.hostIndex));
    }

    // ---- Arrangement ----

    void ReadArrangement() {
        Ensemble().arrangement = Arrangement::Cut;
        if (!Has("/arrangement")) return;
        const std::string at = "/arrangement";
        if (!At(at).is_object()) CheckKeys(at, {});
        if (Has(at + "/kind")) Ensemble().arrangement = Choice(at + "/kind", kArrangements);
        std::vector<std::string> keys = {"kind", "mode", "count", "multiple scattering"};
        switch (Ensemble().arrangement) {
            case Arrangement::Uniform:
            case Arrangement::Cut:
                break;
            case Arrangement::PoissonDisc:
                keys.push_back("distance");
                break;
            case Arrangement::Clumped:
                keys.insert(keys.end(), {"children", "spread"});
                break;
            case Arrangement::Gaussian:
                keys = {"kind", "mode", "count", "deviations", "oriented", "incidences", "azimuths"};
                break;
            case Arrangement::List:
                keys = {"kind", "mode", "particles"};
                keys.insert(keys.end(), {"oriented", "incidences", "azimuths"});
        }
        CheckKeys(at, keys);
        ReadOriented(at);
        const bool isList = Ensemble().arrangement == Arrangement::List;
        s_.mode = isList ? AverageMode::Aggregate : AverageMode::Medium;
        if (Has(at + "/mode")) s_.mode = Choice(at + "/mode", kModes);
        if (Has(at + "/multiple scattering")) ReadMultipleScattering(at + "/multiple scattering");
        if (Has(at + "/count")) Ensemble().count = int(Whole(at + "/count", 1, kMaxUnknowns));
        if (Has(at + "/distance")) Ensemble().minDistance = Number(at + "/distance", 1, 100);
        if (Has(at + "/children")) Ensemble().children = int(Whole(at + "/children", 1, 1e6));
        if (Has(at + "/spread")) Ensemble().spread = Positive(at + "/spread", 1e3, "a number above 0");
        if (Ensemble().arrangement == Arrangement::Gaussian) ReadDeviations(at + "/deviations");
        if (isList) ReadParticleList(*this, at + "/particles", &s_);
    }

    void ReadMultipleScattering(const std::string& at) {
        s_.removesMultipleScattering = Choice(at, Choices<bool>{{"kept", false}, {"removed", true}});
        if (s_.removesMultipleScattering && s_.mode != AverageMode::Medium)
            Fail(at, "clusters as such are what they are; expected \"mode\": \"medium\"");
        if (s_.removesMultipleScattering && s_.method != BulkMethod::Clusters)
            Fail(at, "only clusters have it: expected \"method\": \"clusters\"");
    }

    void ReadOriented(const std::string& at) {
        const bool isOriented = Has(at + "/oriented") && At(at + "/oriented") == true;
        if (Has(at + "/oriented") && !At(at + "/oriented").is_boolean())
            Fail(at + "/oriented",
                 fmt::format("found {}; expected true or false", KindOf(At(at + "/oriented"))));
        for (const std::string key : {"/incidences", "/azimuths"})
            if (!isOriented && Has(at + key))
                Fail(at + key, "only the tables of oriented ensembles have it: expected \"oriented\": true");
        if (!isOriented) return;
        if (s_.method != BulkMethod::Clusters)
            Fail(at + "/oriented", "only clusters have an orientation: expected \"method\": \"clusters\"");
        OrientedSettings& oriented = input_.oriented.emplace();
        // An image of the phase functions has at most 65536 rows.
        constexpr double kMaxIncidences = 181, kMaxAzimuths = 721;
        if (Has(at + "/incidences"))
            oriented.numIncidences = int(Whole(at + "/incidences", 2, kMaxIncidences));
        oriented.numAzimuths = 2 * oriented.numIncidences - 1;
        if (Has(at + "/azimuths")) oriented.numAzimuths = int(Whole(at + "/azimuths", 2, kMaxAzimuths));
    }

    void ReadDeviations(const std::string& at) {
        Numbers(at, Length{3, "along x, y and z"}, -kInf, kInf);
        for (int axis = 0; axis < 3; ++axis)
            Ensemble().deviations[axis] = LengthAt(fmt::format("{}/{}", at, axis), "a length above 0");
    }

    void CheckFractions() const {
        const Packing packing = PackingOf(s_.ensemble);
        const double fraction = VolumeFractionOf(s_.ensemble);
        const bool hasClusters = s_.method == BulkMethod::Clusters;
        const double highest = hasClusters ? packing.highest : 0.74;
        // Sums such as 0.3 + 0.2 are rounded.
        if (fraction <= highest * (1 + 1e-12)) return;
        const std::string at = fmt::format("/species/{}/volume fraction", s_.ensemble.species.size() - 1);
        Fail(at, fmt::format("the volume fractions add up to {:.4g}; {} {:.4g}", fraction,
                             hasClusters ? packing.how : "spheres are packed most closely at", highest));
    }

    // ---- Sizes ----

    void ReadSizes() {
        input_.placeOfArrangement = PlaceOf(Has("/arrangement") ? "/arrangement" : "");
        if (!Has("/sizes")) return;
        const Arrangement arrangement = Ensemble().arrangement;
        if (s_.method != BulkMethod::Clusters)
            Fail("/sizes", "only clusters have sizes: expected \"method\": \"clusters\"");
        if (arrangement == Arrangement::List || arrangement == Arrangement::Gaussian)
            Fail("/sizes", "sizes are those of balls; this arrangement has none");
        const size_t count = NumItems("/sizes", "a growing list of numbers of particles");
        if (count < 2 || count > 8)
            Fail("/sizes",
                 fmt::format("found {}; expected 2 to 8 numbers of particles", KindOf(At("/sizes"))));
        for (size_t i = 0; i < count; ++i)
            input_.sizes.push_back(int(Whole(fmt::format("/sizes/{}", i), 1, kMaxUnknowns)));
        RequireGrowing("/sizes", Numbers("/sizes", {}, 1, kMaxUnknowns), 1);
        Ensemble().count = input_.sizes.back();
    }

    /// The largest realisation: not more unknowns than fit, and a far field of a sensible degree.
    void CheckBalls() const {
        const std::string at = Has("/sizes")               ? fmt::format("/sizes/{}", input_.sizes.size() - 1)
                               : Has("/arrangement/count") ? "/arrangement/count"
                                                           : "/species/0/volume fraction";
        const double k = WavenumberOf(s_, s_.wavelengths.front());
        const double unknowns = NumUnknowns(s_);
        if (unknowns > kMaxUnknowns) {
            constexpr double kBytes = 60 * 2 * 16;  // vectors of GMRES
            Fail(at, fmt::format("{} particles at {:g} nm are {:.3g} unknowns, and take {:.3g} GB for the "
                                 "vectors of the solver alone; expected at most {:g} unknowns",
                                 s_.ensemble.count, s_.wavelengths.front(), unknowns, unknowns * kBytes / 1e9,
                                 kMaxUnknowns));
        }
        const double radius = ReachOf(lacquer::bulk::Ensemble(s_.ensemble));
        if (radius * k > kMaxBallSize)
            Fail(at, fmt::format("the particles of a realisation lie in a ball of {:.4g} um, {:.4g} times "
                                 "the wavelength over 2 pi; expected at most {:g} times: fewer particles, or "
                                 "\"method\": \"independent\"",
                                 radius, radius * k, kMaxBallSize));
    }

    const ParticlesOverrides& overrides_;
    ParticlesInput input_;
    BulkSettings& s_ = input_.settings;
};

}  // namespace

std::vector<double> EvenWavelengths(double begin, double end, double step) {
    if (!(begin >= 1 && begin <= end && end <= 1e6 && step >= 1e-3)) return {};
    // The last one is not lost by rounding.
    const double count = std::floor((end - begin) / step + 1e-9) + 1;
    if (count > kMaxWavelengths) return {};
    std::vector<double> wavelengths;
    for (int i = 0; i < int(count); ++i) wavelengths.push_back(begin + i * step);
    return wavelengths;
}

ParticlesInput ReadParticles(const std::string& path, const ParticlesOverrides& overrides) {
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = size_t(64) << 20});
    return ParticlesReader(bytes.View(), path, overrides).Read();
}

}  // namespace lacquer::bulk
