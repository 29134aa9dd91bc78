#include "capture/svbrdf/fit_checkpoint.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "pbrt/core/error.h"

namespace lacquer::capture {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "lacquer-capture-checkpoint 1";

constexpr const char *kInputRmse = "input rmse", *kTestRmse = "test rmse";
/// In place of an error of photographs for tests that nobody looked at.
constexpr double kNotLooked = -1;

/// Of a tensor in the file, of which one holds those of all fits.
std::string FullName(const std::string& fit, const std::string& name) { return fit + "/" + name; }

std::string TextOf(const std::map<std::string, std::string>& metadata, const std::string& key) {
    const auto found = metadata.find(key);
    return found == metadata.end() ? "" : found->second;
}

void CheckProblem(const FitCheckpoint::Problem& stored, const FitCheckpoint::Problem& wanted,
                  const std::string& path) {
    for (const auto& [name, value] : wanted) {
        const auto found = stored.find(name);
        const std::string was = found == stored.end() ? "none" : found->second;
        if (was == value) continue;
        // Options tell their values, others are hashes.
        throw FileError(path,
                        name.starts_with("--")
                            ? fmt::format("is of a run with {} {}, and this one has {}", name, was, value)
                            : fmt::format("is of a run with other {}", name));
    }
}

FileError Damaged(const std::string& path) {
    return {path, "is damaged: expected the states of fits, as a run of this version leaves them"};
}

}  // namespace

void FitState::SetSteps(std::span<const FitStep> steps) {
    iteration = int(steps.size());
    std::vector<double>&inputs = numbers[kInputRmse], &tests = numbers[kTestRmse];
    for (const FitStep& step : steps) {
        inputs.push_back(step.inputRmse);
        tests.push_back(step.testRmse.value_or(kNotLooked));
    }
}

std::vector<FitStep> FitState::Steps() const {
    const auto count = size_t(iteration);
    const std::vector<double>&inputs = Numbers(kInputRmse, count), &tests = Numbers(kTestRmse, count);
    std::vector<FitStep> steps;
    for (size_t i = 0; i < count; ++i) {
        const bool isLookedAt = tests[i] != kNotLooked;
        steps.push_back({int(i), inputs[i], isLookedAt ? std::optional(tests[i]) : std::nullopt});
    }
    return steps;
}

const std::vector<double>& FitState::Numbers(const std::string& name, size_t count) const {
    const auto found = numbers.find(name);
    if (found != numbers.end() && found->second.size() == count) return found->second;
    throw Damaged(path);
}

const std::vector<float>& FitState::Values(const std::string& name, size_t count) const {
    for (const NamedTensor& tensor : tensors)
        if (tensor.name == name && tensor.values.size() == count) return tensor.values;
    throw Damaged(path);
}

FitCheckpoint::FitCheckpoint(std::string path, Problem problem, double secondsBetween)
    : path_(std::move(path)),
      problem_(std::move(problem)),
      between_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(secondsBetween))),
      written_(Clock::now()) {}

void FitCheckpoint::Load() {
    const SafetensorsFile file(path_);
    if (TextOf(file.Metadata(), "format") != kFormat) throw FileError(path_, "is no checkpoint of a capture");
    try {
        CheckProblem(Json::parse(TextOf(file.Metadata(), "problem")), problem_, path_);
        const Json fits = Json::parse(TextOf(file.Metadata(), "fits"));
        for (const auto& [fit, entry] : fits.items()) {
            FitState state{entry.at("iteration"), entry.at("numbers"), {}, path_};
            for (const std::string name : entry.at("tensors")) {
                const std::vector<size_t>& shape = file.ShapeOf(FullName(fit, name));
                state.tensors.push_back({name, shape, file.Read(FullName(fit, name), shape)});
            }
            states_[fit] = std::move(state);
        }
    } catch (const Json::exception&) {
        throw Damaged(path_);
    }
}

const FitState* FitCheckpoint::Find(const std::string& fit, int iterations) const {
    const auto found = states_.find(fit);
    if (found == states_.end()) return nullptr;
    if (found->second.iteration < 0 || found->second.iteration > iterations) throw Damaged(path_);
    return &found->second;
}

bool FitCheckpoint::IsDue() const { return Clock::now() - written_ >= between_; }

void FitCheckpoint::Write(const std::string& fit, FitState state) {
    states_[fit] = std::move(state);
    std::vector<NamedTensor> tensors;
    Json fits;
    for (const auto& [name, kept] : states_) {
        Json names = Json::array();
        for (const NamedTensor& tensor : kept.tensors) {
            names.push_back(tensor.name);
            tensors.push_back({FullName(name, tensor.name), tensor.shape, tensor.values});
        }
        fits[name] = {{"iteration", kept.iteration}, {"numbers", kept.numbers}, {"tensors", names}};
    }
    WriteSafetensors(path_, tensors,
                     {{"format", kFormat}, {"problem", Json(problem_).dump()}, {"fits", fits.dump()}});
    written_ = Clock::now();
}

void FitCheckpoint::Remove() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
}

}  // namespace lacquer::capture
