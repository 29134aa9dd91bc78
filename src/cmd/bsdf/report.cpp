#include "cmd/bsdf/report.h"

#include <fmt/format.h>

#include "cmd/version.h"

namespace lacquer::cmd {

using namespace measure;

namespace {

using Json = nlohmann::ordered_json;

Json ToJson(glm::dvec3 v) { return Json::array({v.x, v.y, v.z}); }

Json ToJson(const ColorMean& m) {
    return {{"rgb", ToJson(m.Mean())},
            {"rgb_standard_error", ToJson(m.Error())},
            {"luminance", m.Luminance()},
            {"luminance_standard_error", m.LuminanceError()}};
}

Json ToJson(const LobeEnergy& e) {
    return {{"reflected", ToJson(e.reflected)}, {"transmitted", ToJson(e.transmitted)}};
}

Json ToJson(const SampledLobe& s) {
    Json peaks = Json::array();
    for (const SpecularPeak& p : s.peaks)
        peaks.push_back(
            {{"direction", Json::array({p.w.x, p.w.y, p.w.z})}, {"energy_rgb", ToJson(p.energy)}});
    return {{"reflected", ToJson(s.reflected)},
            {"transmitted", ToJson(s.transmitted)},
            {"reflected_without_specular", ToJson(s.smoothReflected)},
            {"transmitted_without_specular", ToJson(s.smoothTransmitted)},
            {"specular_peaks", peaks}};
}

Json ToJson(const Interval& i) {
    return {
        {"difference", i.difference},
        {"simultaneous_confidence_95", Json::array({i.difference - i.halfWidth, i.difference + i.halfWidth})},
        {"agrees", i.HoldsZero()}};
}

Json ToJson(const Difference& d) {
    return {{"blocks", d.numBlocks},
            {"rms_in_standard_errors", d.rms},
            {"largest_in_standard_errors", d.largest},
            {"median_relative_noise", d.medianNoise}};
}

Json ToJson(const Reciprocity& r) {
    return {{"pairs", r.numPairs},
            {"mean_relative_error", r.meanRelative},
            {"max_relative_error", r.maxRelative},
            {"mean_relative_error_of_noise_alone", r.expectedMean},
            {"largest_in_standard_errors", r.largestSigmas}};
}

Json ToJson(const EvaluationCost& c) {
    return {{"evaluate_ns", c.evaluateNs},
            {"evaluate_without_pdf_ns", c.evaluateWithoutPdfNs},
            {"sample_ns", c.sampleNs},
            {"relative_noise_of_one_evaluation", c.noise},
            {"time_times_variance_ns", c.evaluateNs * c.noise * c.noise}};
}

Json ToJson(const EstimatorResult& e, const EnergyAgreement& agreement) {
    Json byAngle = Json::array(), furnaceByAngle = Json::array();
    for (const LobeEnergy& energy : e.energyByAngle) byAngle.push_back(ToJson(energy));
    for (const LobeEnergy& energy : e.furnaceByAngle) furnaceByAngle.push_back(ToJson(energy));
    return {{"name", e.name},
            {"energy", ToJson(e.energy)},
            {"agreement_with_samples",
             {{"reflected", ToJson(agreement.reflected)},
              {"transmitted", ToJson(agreement.transmitted)},
              {"reflected_shape", ToJson(e.reflection)},
              {"transmitted_shape", ToJson(e.transmission)}}},
            {"furnace", ToJson(e.furnace)},
            {"reciprocity", ToJson(e.reciprocity)},
            {"cost", ToJson(e.cost)},
            {"bad_values", e.energy.badSamples},
            {"energy_by_angle", byAngle},
            {"furnace_by_angle", furnaceByAngle}};
}

// ---- Text ----

/// "0.31234 ± 0.00012", in a fixed width.
std::string WithError(double mean, double error) { return fmt::format("{:9.5f} ± {:7.5f}", mean, error); }
std::string WithError(const ColorMean& m) { return WithError(m.Luminance(), m.LuminanceError()); }

double SpecularOf(const SampledLobe& s) {
    return s.reflected.Luminance() + s.transmitted.Luminance() - s.smoothReflected.Luminance() -
           s.smoothTransmitted.Luminance();
}

std::string RGBText(const ColorMean& m) {
    const glm::dvec3 v = m.Mean(), e = m.Error();
    return fmt::format("{:7.4f} {:7.4f} {:7.4f}  (± {:.4f} {:.4f} {:.4f})", v.x, v.y, v.z, e.x, e.y, e.z);
}

std::string Head(const BsdfResult& r) {
    std::string text = fmt::format(
        "{} \"{}\" of {}, at uv ({:g}, {:g})\nlight from theta {:g}°, phi {:g}°; linear sRGB under D65; "
        "energies "
        "are parts of the light's power\n",
        r.type, r.material, r.scene, r.uv.x, r.uv.y, r.thetaDeg, r.phiDeg);
    text += fmt::format("± is one standard error; seed {}\n", r.seed);
    return text;
}

std::string EnergyTable(const BsdfResult& r) {
    std::string text = "\nEnergy without specular peaks, luminance\n";
    text += fmt::format("  {:<20} {:>19}  {:>19}\n", "", "reflected", "transmitted");
    const auto row = [&](const std::string& name, const ColorMean& a, const ColorMean& b) {
        text += fmt::format("  {:<20} {}  {}\n", name, WithError(a), r.transmits ? WithError(b) : "");
    };
    row("samples", r.sampled.smoothReflected, r.sampled.smoothTransmitted);
    for (const EstimatorResult& e : r.estimators) row(e.name, e.energy.reflected, e.energy.transmitted);
    text += fmt::format("\nAll light, RGB, by samples\n  reflected   {}\n", RGBText(r.sampled.reflected));
    if (r.transmits) text += fmt::format("  transmitted {}\n", RGBText(r.sampled.transmitted));
    for (const SpecularPeak& p : r.sampled.peaks)
        text += fmt::format("  specular peak toward ({:.4f}, {:.4f}, {:.4f}): {:.5f} {:.5f} {:.5f}\n", p.w.x,
                            p.w.y, p.w.z, p.energy.x, p.energy.y, p.energy.z);
    return text;
}

std::string AgreementTable(const BsdfResult& r) {
    std::string text = fmt::format(
        "\nAgreement with the samples: difference of energies with its interval ({} comparisons together "
        "hold "
        "with\n"
        "95 %: one sheet in twenty has a DIFFERS by chance), and differences of blocks of the lobe in "
        "standard "
        "errors\n(rms 1: noise alone)\n",
        NumAgreements(r));
    const auto row = [&](const EstimatorResult& e, const char* side, const Interval& i, const Difference& d) {
        text +=
            fmt::format("  {:<20} {:<12} {:+.6f} ± {:.6f}  {:<8} rms {:5.3f}, largest {:4.1f} of {} blocks\n",
                        e.name, side, i.difference, i.halfWidth, i.HoldsZero() ? "agrees" : "DIFFERS", d.rms,
                        d.largest, d.numBlocks);
    };
    const std::vector<EnergyAgreement> agreements = AgreementsWithSamples(r);
    for (size_t i = 0; i < r.estimators.size(); ++i) {
        const EstimatorResult& e = r.estimators[i];
        row(e, "reflected", agreements[i].reflected, e.reflection);
        if (r.transmits) row(e, "transmitted", agreements[i].transmitted, e.transmission);
    }
    return text;
}

std::string FurnaceTable(const BsdfResult& r) {
    const double specular = SpecularOf(r.sampledFurnace);
    std::string text =
        "\nWhite furnace: radiance toward this direction in a white environment (n^2 on a side of index n), "
        "luminance;\n1 for what neither absorbs nor loses\n";
    text += fmt::format("  {:<20} {:9.5f}\n", "samples",
                        r.sampledFurnace.reflected.Luminance() + r.sampledFurnace.transmitted.Luminance());
    for (const EstimatorResult& e : r.estimators) {
        const double value = e.furnace.reflected.Luminance() + e.furnace.transmitted.Luminance() + specular;
        const double error =
            std::hypot(e.furnace.reflected.LuminanceError(), e.furnace.transmitted.LuminanceError());
        text += fmt::format("  {:<20} {}\n", e.name, WithError(value, error));
    }
    if (r.interfaces.empty()) return text;
    text += "  Each interface by itself (average of wavelengths): absorbed or lost by single scattering\n";
    text += fmt::format("    {:<24}", "");
    for (const double a : r.lossAnglesDeg) text += fmt::format("{:>9}", fmt::format("{:g}°", a));
    for (const InterfaceLoss& loss : r.interfaces) {
        const auto row = [&](const char* from, const std::vector<double>& values) {
            if (values.empty()) return;
            text += fmt::format("\n    interface {} from {:<10}", loss.index, from);
            for (const double v : values) text += fmt::format("{:9.4f}", std::abs(v) < 5e-5 ? 0.0 : v);
        };
        row("above", loss.fromAbove);
        row("below", loss.fromBelow);
    }
    return text + "\n";
}

std::string ReciprocityTable(const BsdfResult& r) {
    std::string text =
        "\nReciprocity: f(wo, wi) n_i^2 against f(wi, wo) n_o^2 over pairs of directions, relative "
        "differences\n";
    for (const EstimatorResult& e : r.estimators) {
        const Reciprocity& p = e.reciprocity;
        text += fmt::format("  {:<20} mean {:.2e}, max {:.2e} of {} pairs", e.name, p.meanRelative,
                            p.maxRelative, p.numPairs);
        if (p.largestSigmas > 0)
            text += fmt::format("; noise alone gives a mean of {:.2e}; largest {:.1f} standard errors",
                                p.expectedMean, p.largestSigmas);
        text += "\n";
    }
    return text;
}

std::string CostTable(const BsdfResult& r) {
    std::string text = "\nCost of one call on one thread\n";
    text += fmt::format("  {:<20} {:>12} {:>12} {:>12} {:>12} {:>16}\n", "", "f and pdf", "f alone",
                        "Sample()", "noise of f", "time x variance");
    for (const EstimatorResult& e : r.estimators)
        text += fmt::format("  {:<20} {:>9.0f} ns {:>9.0f} ns {:>9.0f} ns {:>12.3f} {:>13.0f} ns\n", e.name,
                            e.cost.evaluateNs, e.cost.evaluateWithoutPdfNs, e.cost.sampleNs, e.cost.noise,
                            e.cost.evaluateNs * e.cost.noise * e.cost.noise);
    return text;
}

std::string AngleTable(const BsdfResult& r) {
    std::string text =
        "\nAlbedo by angle of incidence, specular peaks included: RGB by samples, then luminances; furnace "
        "by "
        "samples\n";
    text += fmt::format("  {:>5}  {:>23}  {:>7}", "angle", "reflected RGB", "± Y");
    if (r.transmits) text += fmt::format("  {:>23}  {:>7}", "transmitted RGB", "± Y");
    text += fmt::format("  {:>7}", "furnace");
    for (const EstimatorResult& e : r.estimators) text += fmt::format("  {:>16}", e.name + " Y");
    text += "\n";
    for (size_t i = 0; i < r.anglesDeg.size(); ++i) {
        const SampledLobe &s = r.sampledByAngle[i], &f = r.sampledFurnaceByAngle[i];
        const auto rgb = [&](const ColorMean& m) {
            const glm::dvec3 v = m.Mean();
            text += fmt::format("  {:7.4f} {:7.4f} {:7.4f}  {:7.5f}", v.x, v.y, v.z, m.LuminanceError());
        };
        text += fmt::format("  {:>4}°", r.anglesDeg[i]);
        rgb(s.reflected);
        if (r.transmits) rgb(s.transmitted);
        text += fmt::format("  {:7.4f}", f.reflected.Luminance() + f.transmitted.Luminance());
        for (const EstimatorResult& e : r.estimators) {
            const LobeEnergy& m = e.energyByAngle[i];
            text += fmt::format("  {:7.4f} ± {:6.4f}",
                                m.reflected.Luminance() + m.transmitted.Luminance() + SpecularOf(s),
                                std::hypot(m.reflected.LuminanceError(), m.transmitted.LuminanceError()));
        }
        text += "\n";
    }
    return text;
}

}  // namespace

Json ToJson(const BsdfResult& r) {
    Json json{{"schema", "lacquer-bsdf-1"},
              {"version", kVersion},
              {"material", r.material},
              {"type", r.type},
              {"scene", r.scene},
              {"uv", Json::array({r.uv.x, r.uv.y})},
              {"wi_degrees", {{"theta", r.thetaDeg}, {"phi", r.phiDeg}}},
              {"wi", Json::array({r.w.x, r.w.y, r.w.z})},
              {"resolution", r.resolution},
              {"samples_per_pixel", r.samplesPerPixel},
              {"histogram_samples", r.histogramSamples},
              {"seed", r.seed},
              {"stochastic", r.isStochastic},
              {"pdf", r.pdfName},
              {"eta", r.sampled.eta},
              {"samples", ToJson(r.sampled)},
              {"bad_samples", r.sampled.badSamples},
              {"furnace_by_samples", ToJson(r.sampledFurnace)}};
    json["estimators"] = Json::array();
    const std::vector<EnergyAgreement> agreements = AgreementsWithSamples(r);
    for (size_t i = 0; i < r.estimators.size(); ++i)
        json["estimators"].push_back(ToJson(r.estimators[i], agreements[i]));
    json["simultaneous_comparisons"] = NumAgreements(r);
    json["angles_degrees"] = r.anglesDeg;
    json["samples_by_angle"] = Json::array();
    for (const SampledLobe& s : r.sampledByAngle) json["samples_by_angle"].push_back(ToJson(s));
    json["furnace_by_samples_by_angle"] = Json::array();
    for (const SampledLobe& s : r.sampledFurnaceByAngle)
        json["furnace_by_samples_by_angle"].push_back(ToJson(s));
    json["interface_losses"] = Json::array();
    for (const InterfaceLoss& loss : r.interfaces)
        json["interface_losses"].push_back({{"interface", loss.index},
                                            {"angles_degrees", r.lossAnglesDeg},
                                            {"from_above", loss.fromAbove},
                                            {"from_below", loss.fromBelow}});
    return json;
}

std::string ToText(const BsdfResult& r) {
    return Head(r) + EnergyTable(r) + AgreementTable(r) + FurnaceTable(r) + ReciprocityTable(r) +
           CostTable(r) + AngleTable(r);
}

}  // namespace lacquer::cmd
