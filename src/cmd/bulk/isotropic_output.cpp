// Tables of ensembles without an axis, of one size of the ball or extrapolated over several.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "bulk/table/bulk_computation.h"
#include "bulk/table/size_extrapolation.h"
#include "cmd/bulk/bulk_output.h"
#include "cmd/bulk/bulk_plan.h"
#include "cmd/bulk/report.h"
#include "cmd/command_support.h"
#include "cmd/version.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;

/// "12.3 +- 0.1".
std::string ToText(const ScatteringAverage::Value& value) {
    return value.error > 0 ? fmt::format("{:.4g} +- {:.1g}", value.mean, value.error)
                           : fmt::format("{:.4g}", value.mean);
}

/// With the digits of tables.
double Rounded(double number) { return std::stod(fmt::format("{:.9g}", number)); }

nlohmann::ordered_json ToJson(const SizeResult& result) {
    nlohmann::ordered_json json;
    if (result.count > 0) {
        json["particles"] = result.count;
        json["radius_um"] = Rounded(result.ballRadius);
    }
    for (const auto& [name, values] :
         {std::pair("sigma_s", &result.sigmaS), {"sigma_a", &result.sigmaA}, {"g", &result.g}})
        for (const ScatteringAverage::Value& value : *values) {
            json[name].push_back(Rounded(value.mean));
            json["standard_error"][name].push_back(Rounded(value.error));
        }
    return json;
}

class IsotropicOutput final : public BulkOutput {
  public:
    IsotropicOutput(const ParticlesInput& input, const BulkFiles& files) : input_(input), files_(files) {
        for (BulkSettings& settings : SettingsOf(input))
            computations_.push_back(std::make_unique<BulkComputation>(std::move(settings)));
    }

    std::vector<EnsembleComputation*> Computations() override {
        std::vector<EnsembleComputation*> all;
        if (HasClusters())
            for (const auto& computation : computations_) all.push_back(computation.get());
        return all;
    }

    void WriteTable() override {
        for (const auto& computation : computations_) {
            std::vector<BulkRow> rows = computation->Rows();
            sizes_.push_back(ResultOf(*computation, rows));
            table_ = computation->TableOf(std::move(rows));
        }
        if (sizes_.size() > 1) {
            sizes_.push_back(Extrapolate(sizes_));
            UseExtrapolated(sizes_.back());
        }
        table_.made = Made().dump();
        WriteText(files_.table, WriteBulkTable(table_));
    }

    void Tell(Console* console) const override {
        BulkSettings settings = input_.settings;
        settings.method = BulkMethod::Independent;
        const BulkTable independent = BulkComputation(settings).Table();
        for (const SizeResult& size : sizes_) {
            if (sizes_.size() > 1)
                console->Info(size.count > 0
                                  ? fmt::format("{} particles, R = {:.4g} um:", size.count, size.ballRadius)
                                  : "extrapolated to 1/R = 0:");
            console->Info(fmt::format("{:>8}  {:<20}{:<20}{:<20}{}", "nm", "sigma_s [1/mm]", "sigma_a [1/mm]",
                                      "g", "sigma_t over that of independent particles"));
            for (size_t w = 0; w < size.sigmaS.size(); ++w) {
                const double sigmaT = size.sigmaS[w].mean + size.sigmaA[w].mean;
                console->Info(fmt::format("{:>8g}  {:<20}{:<20}{:<20}{:.4g}", independent.wavelengths[w],
                                          ToText(size.sigmaS[w]), ToText(size.sigmaA[w]), ToText(size.g[w]),
                                          sigmaT / (independent.sigmaS[w] + independent.sigmaA[w])));
            }
        }
        std::string realizations;
        for (const auto& computation : computations_)
            if (HasClusters())
                realizations += fmt::format("{}{}", realizations.empty() ? "; realisations: " : ", ",
                                            computation->NumRealizations());
        console->Info(
            fmt::format("{}: {} wavelengths{}", files_.table, table_.wavelengths.size(), realizations));
        WarnOfChapter(console);
    }

    void WritePage() const override {
        BulkReportContext context;
        context.input = input_.json;
        context.command = files_.command;
        context.sizes = sizes_;
        WriteBulkReport(files_.report, *computations_.back(), table_, context, files_.table);
    }

  private:
    bool HasClusters() const { return input_.settings.method == BulkMethod::Clusters; }

    nlohmann::ordered_json Made() const {
        nlohmann::ordered_json made;
        made["by"] = fmt::format("Lacquer {}", kVersion);
        made["seed"] = input_.settings.seed;
        if (HasClusters()) {
            nlohmann::ordered_json realizations, refused;  // a number, or a list for several sizes
            double energyError = 0;
            for (const auto& computation : computations_) {
                realizations.push_back(computation->NumRealizations());
                refused.push_back(computation->NumRefused());
                energyError = std::max(energyError, computation->WorstEnergyError());
            }
            made["realisations"] = computations_.size() > 1 ? realizations : realizations[0];
            made["refused"] = computations_.size() > 1 ? refused : refused[0];
            made["energy_error"] = energyError;
        }
        if (sizes_.size() > 1)
            for (const SizeResult& size : sizes_) made["sizes"].push_back(ToJson(size));
        made["input"] = nlohmann::ordered_json::parse(input_.json);
        return made;
    }

    /// Coefficients of the medium; its phase function and g are those of the largest ball.
    void UseExtrapolated(const SizeResult& result) {
        for (size_t w = 0; w < table_.wavelengths.size(); ++w) {
            table_.sigmaS[w] = std::max(0., result.sigmaS[w].mean);
            table_.sigmaA[w] = std::max(0., result.sigmaA[w].mean);
            table_.errorSigmaS[w] = result.sigmaS[w].error;
            table_.errorSigmaA[w] = result.sigmaA[w].error;
        }
    }

    void WarnOfChapter(Console* console) const {
        if (!HasClusters() || input_.settings.mode != AverageMode::Chapter) return;
        std::vector<EnergyBalance> balances;
        for (size_t w = 0; w < table_.wavelengths.size(); ++w) {
            const ScatteringAverage a = computations_.back()->AverageAt(w);
            balances.push_back({a.extinction.mean, a.scattering.mean, a.absorption.mean});
        }
        console->Warn(WarningOfChapter(balances));
    }

    const ParticlesInput& input_;
    BulkFiles files_;
    std::vector<std::unique_ptr<BulkComputation>> computations_;  ///< one, or one for each size
    BulkTable table_;
    std::vector<SizeResult> sizes_;  ///< and then the extrapolated one, if there are several
};

}  // namespace

std::unique_ptr<BulkOutput> MakeIsotropicOutput(const ParticlesInput& input, const BulkFiles& files) {
    return std::make_unique<IsotropicOutput>(input, files);
}

}  // namespace lacquer::cmd
