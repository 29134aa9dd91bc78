// Records of forward runs, which a resumed estimation finds.
#include <algorithm>
#include <array>
#include <cstring>

#include "estimate/emulator/runs.h"
#include "fuzz/fuzz_target.h"
#include "pbrt/core/rng.h"

namespace lacquer::fuzz {
namespace {

constexpr size_t kParameters = 2, kSummaries = 3, kHead = 24, kNumbers = 1 + kParameters + kSummaries;

// The checksums behind all records made right, which no mutation does; the layout is that of
// estimate/emulator/runs.cpp.
std::string RunsWithChecksums(std::string_view bytes) {
    std::string log(bytes);
    constexpr size_t kRecord = kNumbers * sizeof(double);
    for (size_t at = kHead; at + kRecord + sizeof(uint64_t) <= log.size(); at += kRecord + sizeof(uint64_t)) {
        std::array<double, kNumbers> record{};
        std::memcpy(record.data(), &log[at], kRecord);
        uint64_t checksum = kNumbers;
        for (const double number : record) checksum = Hash(checksum, number);
        std::memcpy(&log[at + kRecord], &checksum, sizeof checksum);
    }
    return log;
}

void RunRecords(std::string_view bytes) {
    const InputFolder folder;
    const std::string path = folder.Write("runs.bin", RunsWithChecksums(bytes));
    estimate::Vector parameters(kParameters), summaries(kSummaries);
    parameters << 0.25, -1;
    estimate::RunLog log(path, kParameters, kSummaries);
    if (!log.Recall(parameters, 1, &summaries)) log.Append(parameters, 1, summaries.setOnes());
    Require(estimate::RunLog(path, kParameters, kSummaries).Recall(parameters, 1, &summaries),
            "a run that was recalled or appended is there");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "run_log", RunRecords);

}  // namespace lacquer::fuzz
