// results.json and table.json of an earlier comparison or survey, which name files that a new one removes.
#include "cmd/earlier_files.h"

#include <filesystem>

#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void EarlierFiles(std::string_view bytes) {
    const InputFolder folder;
    folder.Write("results.json", bytes);
    folder.Write("table.json", bytes);
    const auto all = {cmd::FilesOfEarlierComparison(folder.Path()), cmd::FilesOfEarlierSurvey(folder.Path())};
    for (const auto& files : all)
        for (const std::filesystem::path file : files) {
            Require(file.is_relative(), "files are in the folder");
            for (const auto& part : file) Require(part != "..", "files are in the folder");
        }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "earlier_files", EarlierFiles);

}  // namespace lacquer::fuzz
