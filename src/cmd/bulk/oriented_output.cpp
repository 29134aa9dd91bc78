// Tables of ensembles that keep their axis: a JSON file, and an image of the phase functions beside it.
#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "bulk/table/oriented_computation.h"
#include "cmd/bulk/bulk_output.h"
#include "cmd/bulk/bulk_plan.h"
#include "cmd/bulk/report.h"
#include "cmd/command_support.h"
#include "cmd/version.h"
#include "pbrt/image/image.h"
#include "pbrt/phases/oriented_file.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::cmd {
namespace {

using namespace bulk;

class OrientedOutput final : public BulkOutput {
  public:
    OrientedOutput(const ParticlesInput& input, const BulkFiles& files)
        : input_(input), files_(files), computation_(input.settings, *input.oriented) {}

    void CheckFiles() const override {
        if (ExtensionOf(files_.table) == "exr")
            BadOption("out", files_.table,
                      "a name that does not end in .exr, as that of the image beside it does");
        std::error_code ignored;
        if (std::filesystem::exists(files_.table, ignored) &&
            !std::filesystem::is_regular_file(files_.table, ignored))
            BadOption("out", files_.table, "a regular file, as there is an image beside it");
        CheckOutputFile(ImageOfOrientedBulk(files_.table));
    }

    std::vector<EnsembleComputation*> Computations() override { return {&computation_}; }

    void WriteTable() override {
        table_ = computation_.Table();
        nlohmann::ordered_json made;
        made["by"] = fmt::format("Lacquer {}", kVersion);
        made["seed"] = input_.settings.seed;
        made["realisations"] = computation_.NumRealizations();
        made["refused"] = computation_.NumRefused();
        made["energy_error"] = computation_.WorstEnergyError();
        made["input"] = nlohmann::ordered_json::parse(input_.json);
        table_.made = made.dump();
        WriteOrientedBulk(table_, files_.table);
    }

    void Tell(Console* console) const override {
        const OrientedGrid grid(table_);
        console->Info(fmt::format("{:>8}  {:<38}{:<12}{:<12}{}", "nm", "sigma_s [1/mm] along, mean, across",
                                  "g", "error of p", "changed to be reciprocal"));
        for (size_t w = 0; w < table_.wavelengths.size(); ++w) {
            const std::vector<double>& sigma = table_.sigmaS[w];
            const std::string range = fmt::format("{:.4g}, {:.4g}, {:.4g}", sigma.front(),
                                                  grid.MeanOverIncidences(sigma), sigma.back());
            console->Info(fmt::format(
                "{:>8g}  {:<38}{:<12.4g}{:<12}{:.2g} %", table_.wavelengths[w], range, table_.g[w],
                table_.errorPhase.empty() ? "unknown" : fmt::format("{:.2g} %", 100 * table_.errorPhase[w]),
                100 * table_.errorReciprocity[w]));
        }
        console->Info(fmt::format("{}: {} wavelengths, {} incidences; realisations: {}", files_.table,
                                  table_.wavelengths.size(), table_.NumIncidences(),
                                  computation_.NumRealizations()));
        WarnOfChapter(console);
    }

    void WritePage() const override {
        BulkReportContext context;
        context.input = input_.json;
        context.command = files_.command;
        WriteOrientedReport(files_.report, computation_, table_, context, files_.table);
    }

  private:
    void WarnOfChapter(Console* console) const {
        if (input_.settings.mode != AverageMode::Chapter) return;
        std::vector<EnergyBalance> balances;
        for (size_t w = 0; w < table_.wavelengths.size(); ++w) {
            const OrientedMeans means = computation_.MeansOverIncidences(w);
            balances.push_back({means.extinction.mean, means.scattering.mean, means.absorption.mean});
        }
        console->Warn(WarningOfChapter(balances));
    }

    const ParticlesInput& input_;
    BulkFiles files_;
    OrientedComputation computation_;
    OrientedBulkTable table_;
};

}  // namespace

std::unique_ptr<BulkOutput> MakeOrientedOutput(const ParticlesInput& input, const BulkFiles& files) {
    return std::make_unique<OrientedOutput>(input, files);
}

}  // namespace lacquer::cmd
