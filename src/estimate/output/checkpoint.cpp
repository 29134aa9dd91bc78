#include "estimate/output/checkpoint.h"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "pbrt/core/error.h"
#include "pbrt/core/hash_bytes.h"
#include "pbrt/core/json_number.h"

namespace lacquer::estimate {

namespace {

using Json = nlohmann::ordered_json;

// Numbers as the integers of their bits: exact, and infinities and NaN are nothing special.
Json Put(double x) { return std::bit_cast<uint64_t>(x); }
Json Put(uint64_t x) { return x; }
Json Put(int x) { return x; }
Json Put(bool x) { return x; }
Json Put(const Vector& v) {
    Json array = Json::array();
    for (const double x : v) array.push_back(Put(x));
    return array;
}
void Get(const Json& json, double* x) { *x = std::bit_cast<double>(WholeNumber<uint64_t>(json)); }
void Get(const Json& json, uint64_t* x) { *x = WholeNumber<uint64_t>(json); }
void Get(const Json& json, int* x) { *x = WholeNumber<int>(json); }
void Get(const Json& json, bool* x) { *x = json.get<bool>(); }
void Get(const Json& json, Vector* v) {
    v->resize(Eigen::Index(json.size()));
    for (Eigen::Index i = 0; i < v->size(); ++i) Get(json.at(size_t(i)), &(*v)[i]);
}

/// Calls f(name, field) for all that a state has; the same list writes and reads.
template <class State, class F>
void ForEachField(State& s, F f) {
    f("step", s.step);
    f("y", s.point.y);
    f("log_density", s.point.logDensity);
    f("gradient", s.point.gradient);
    f("log_step", s.adaptation.logStep);
    f("log_step_average", s.adaptation.logStepAverage);
    f("adaptation_error", s.adaptation.error);
    f("adaptation_center", s.adaptation.center);
    f("adaptation_count", s.adaptation.count);
    f("metric", s.metric);
    f("window_count", s.window.count);
    f("window_mean", s.window.mean);
    f("window_squares", s.window.squares);
    f("gradient_mean", s.gradientMean);
    f("gradient_squares", s.gradientSquares);
    f("accepted", s.accepted);
    f("kind", s.kind);
    f("log_steps", s.logSteps);
}
template <class AnyDraw, class F>
void ForEachFieldOfDraw(AnyDraw& d, F f) {
    f("y", d.y);
    f("log_density", d.logDensity);
    f("kind", d.kind);
    f("accept", d.acceptStat);
    f("step_size", d.stepSize);
    f("leapfrog", d.numLeapfrog);
    f("divergent", d.isDivergent);
    f("accepted", d.isAccepted);
    f("energy", d.energy);
}

constexpr int kVersion = 2;
constexpr const char* kDamaged =
    "is no checkpoint, or damaged; without it the chains begin anew, from the simulations that are there";

/// Of everything else that a checkpoint has: a digit that has changed would be another number.
std::string ChecksumOf(const Json& json) { return fmt::format("{:016x}", HashOfBytes(json.dump())); }

}  // namespace

std::string CheckpointText(const Checkpoint& checkpoint) {
    Json json;
    json["lacquer_checkpoint"] = kVersion;
    json["settings"] = checkpoint.settings;
    json["states"] = Json::array();
    for (const ChainState& state : checkpoint.states) {
        Json fields;
        ForEachField(state, [&](const char* name, const auto& field) { fields[name] = Put(field); });
        json["states"].push_back(std::move(fields));
    }
    json["draws"] = Json::array();
    for (const auto& chain : checkpoint.draws) {
        Json rows = Json::array();
        for (const Draw& draw : chain) {
            Json row = Json::array();
            ForEachFieldOfDraw(draw, [&](const char*, const auto& field) { row.push_back(Put(field)); });
            rows.push_back(std::move(row));
        }
        json["draws"].push_back(std::move(rows));
    }
    json["checksum"] = ChecksumOf(json);
    return json.dump() + "\n";
}

Checkpoint ParseCheckpoint(const std::string& text, const std::string& path, const std::string& settings) {
    Checkpoint checkpoint;
    try {
        Json json = Json::parse(text);
        if (json.at("lacquer_checkpoint") != kVersion) throw FileError(path, "is of another version");
        const Json checksum = json.at("checksum");
        json.erase("checksum");
        if (checksum != ChecksumOf(json)) throw FileError(path, kDamaged);
        checkpoint.settings = json.at("settings").get<std::string>();
        if (checkpoint.settings != settings) throw FileError(path, "is of a computation with other settings");
        for (const Json& fields : json.at("states")) {
            ChainState state;
            ForEachField(state, [&](const char* name, auto& field) { Get(fields.at(name), &field); });
            checkpoint.states.push_back(std::move(state));
        }
        for (const Json& rows : json.at("draws")) {
            std::vector<Draw> chain;
            for (const Json& row : rows) {
                Draw draw;
                size_t column = 0;
                ForEachFieldOfDraw(draw, [&](const char*, auto& field) { Get(row.at(column++), &field); });
                chain.push_back(std::move(draw));
            }
            checkpoint.draws.push_back(std::move(chain));
        }
    } catch (const nlohmann::json::exception&) {
        throw FileError(path, kDamaged);
    }
    return checkpoint;
}

}  // namespace lacquer::estimate
