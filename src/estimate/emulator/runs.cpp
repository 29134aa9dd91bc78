#include "estimate/emulator/runs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/output_file.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::estimate {

namespace {

constexpr char kMagic[8] = {'l', 'q', 'r', 'u', 'n', 's', '0', '1'};

/// What a record ends with, so that a torn one is known.
uint64_t Checksum(const std::vector<double>& record) {
    uint64_t h = record.size();
    for (const double number : record) h = Hash(h, number);
    return h;
}

std::vector<double> RecordOf(const Vector& parameters, uint64_t seed, const Vector& summaries) {
    std::vector<double> record(1);
    std::memcpy(record.data(), &seed, sizeof seed);
    record.insert(record.end(), parameters.begin(), parameters.end());
    record.insert(record.end(), summaries.begin(), summaries.end());
    return record;
}

/// The first values of what is left, if they are whole.
template <class T>
bool TakeValues(std::string_view* rest, T* values, size_t count) {
    if (rest->size() < count * sizeof(T)) return false;
    std::memcpy(values, rest->data(), count * sizeof(T));
    rest->remove_prefix(count * sizeof(T));
    return true;
}
template <class T>
void AppendValues(std::string* bytes, const T* values, size_t count) {
    bytes->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}
void AppendRecord(std::string* bytes, const std::vector<double>& record) {
    AppendValues(bytes, record.data(), record.size());
    const uint64_t checksum = Checksum(record);
    AppendValues(bytes, &checksum, 1);
}

}  // namespace

void Runs::Append(const Runs& other) {
    if (Count() == 0) {
        *this = other;
        return;
    }
    Matrix columns(parameters.rows(), Count() + other.Count());
    columns << parameters, other.parameters;
    Matrix rows(Count() + other.Count(), summaries.cols());
    rows << summaries, other.summaries;
    parameters = std::move(columns);
    summaries = std::move(rows);
}

Runs Runs::Select(const std::vector<Eigen::Index>& indices) const {
    return {parameters(Eigen::all, indices), summaries(indices, Eigen::all)};
}

RunLog::RunLog(std::string path, Eigen::Index numParameters, Eigen::Index numSummaries)
    : path_(std::move(path)), numParameters_(numParameters), numSummaries_(numSummaries) {
    std::error_code ignored;
    if (std::filesystem::exists(path_, ignored)) ReadRecords();
    Rewrite();
}

void RunLog::ReadRecords() {
    const FileBytes bytes = ReadFileBytes(path_, {}, {.maxBytes = size_t(4) << 30});
    std::string_view rest = bytes.View();
    if (rest.empty()) throw FileError(path_, "is empty; expected simulations of a run that was stopped");
    char magic[8];
    uint64_t sizes[2];
    const bool isHeadWhole = TakeValues(&rest, magic, 8);
    if (std::memcmp(bytes.data.get(), kMagic, std::min<size_t>(bytes.size, 8)) != 0)
        throw FileError(path_, "is no file of simulations: it begins with other bytes");
    if (!isHeadWhole || !TakeValues(&rest, sizes, 2))
        throw FileError(path_, fmt::format("ends after {} bytes, within its head; without this file the work "
                                           "begins anew",
                                           bytes.size));
    if (sizes[0] != uint64_t(numParameters_) || sizes[1] != uint64_t(numSummaries_))
        throw FileError(path_,
                        fmt::format("has simulations of {} parameters and {} summaries, expected {} and {}",
                                    sizes[0], sizes[1], numParameters_, numSummaries_));
    std::vector<double> record(size_t(1 + numParameters_ + numSummaries_));
    for (uint64_t checksum; TakeValues(&rest, record.data(), record.size()) &&
                            TakeValues(&rest, &checksum, 1) && checksum == Checksum(record);)
        records_.push_back(record);
}

void RunLog::Rewrite() {
    std::string bytes;
    AppendValues(&bytes, kMagic, 8);
    const uint64_t sizes[2] = {uint64_t(numParameters_), uint64_t(numSummaries_)};
    AppendValues(&bytes, sizes, 2);
    for (const auto& record : records_) AppendRecord(&bytes, record);
    OutputFile file(path_);
    file.Write(bytes);
    file.Finish();
}

bool RunLog::Recall(const Vector& parameters, uint64_t seed, Vector* summaries) {
    if (next_ >= records_.size()) return false;
    const std::vector<double>& record = records_[next_];
    const std::vector<double> expected = RecordOf(parameters, seed, Vector());
    if (std::memcmp(record.data(), expected.data(), expected.size() * sizeof(double)) != 0) {
        records_.resize(next_);
        Rewrite();
        return false;
    }
    *summaries = Eigen::Map<const Vector>(record.data() + 1 + numParameters_, numSummaries_);
    ++next_;
    return true;
}

void RunLog::Append(const Vector& parameters, uint64_t seed, const Vector& summaries) {
    records_.push_back(RecordOf(parameters, seed, summaries));
    next_ = records_.size();
    std::string bytes;
    AppendRecord(&bytes, records_.back());
    std::ofstream out(path_, std::ios::binary | std::ios::app);
    if (!(out << bytes).flush()) throw FileError(path_, "cannot be written");
}

Runs RunSimulator(const Simulator& simulator, const Matrix& parameters, uint64_t seed, RunLog* log,
                  Observer* observer) {
    // Runs are written in their order, a block at a time, so that an interruption loses one block.
    constexpr Eigen::Index kBlock = 64;
    const Eigen::Index count = parameters.cols();
    Runs runs{parameters, Matrix(count, Eigen::Index(simulator.SummaryNames().size()))};
    const auto seedOf = [seed](Eigen::Index i) { return Hash(seed, uint64_t(i)); };
    Eigen::Index first = 0;
    Vector recalled;
    while (log && first < count && log->Recall(parameters.col(first), seedOf(first), &recalled)) {
        runs.summaries.row(first++) = recalled;
        if (observer) observer->Advance(1);
    }
    while (first < count) {
        if (observer && observer->ShouldStop()) throw Interrupted{};
        const Eigen::Index last = std::min(count, first + kBlock);
        ParallelFor(last - first, [&](int64_t k) {
            const Eigen::Index i = first + k;
            runs.summaries.row(i) =
                simulator.Simulate(simulator.Parameters().ToNatural(parameters.col(i)), seedOf(i));
            if (observer) observer->Advance(1);
        });
        for (Eigen::Index i = first; log && i < last; ++i)
            log->Append(parameters.col(i), seedOf(i), runs.summaries.row(i));
        first = last;
    }
    return runs;
}

}  // namespace lacquer::estimate
