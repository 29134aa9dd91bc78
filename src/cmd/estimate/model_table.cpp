// The models with their parameters, as a table.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cmd/command_support.h"
#include "cmd/estimate/estimate_job.h"

namespace lacquer::cmd {

using namespace estimate;
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const Prior& prior) {
    return {{"mean", prior.mean}, {"sd", prior.sd}, {"low", prior.low}, {"high", prior.high}};
}

Json ToJson(const MaterialModel& model, double distance) {
    Json json{{"name", std::string(model.Name())},
              {"summaries", DefaultSummaries(model)},
              {"parameters", Json::array()}};
    for (const ModelParameter& p : model.Parameters()) {
        Json entry{{"name", std::string(p.name)},
                   {"unit", std::string(p.unit)},
                   {"meaning", p.meaning.Full()},
                   {"prior", ToJson(PriorAt(p, PriorSet::Test, distance))},
                   {"demo_prior", ToJson(PriorAt(p, PriorSet::Demo, distance))},
                   {"smooth", p.smooth}};
        if (p.optional) entry["fixed_unless_free"] = p.fixedValue;
        json["parameters"].push_back(std::move(entry));
    }
    return json;
}

}  // namespace

std::string ModelTable(bool asJson, double distance) {
    Json json = Json::array();
    std::string text;
    for (const MaterialModel* model : AllModels()) {
        json.push_back(ToJson(*model, distance));
        text += fmt::format("{}{}\n", text.empty() ? "" : "\n", model->Name());
        for (const ModelParameter& p : model->Parameters()) {
            const Prior prior = PriorAt(p, PriorSet::Test, distance);
            text += fmt::format("  {:<12} {:>8.4g} +- {:<8.4g} {:>6.4g} ... {:<8.4g} {:<10} {}{}\n", p.name,
                                prior.mean, prior.sd, prior.low, prior.high, p.unit, p.meaning.Full(),
                                p.optional ? fmt::format(" ({:g} unless it is free)", p.fixedValue) : "");
        }
    }
    text += fmt::format(
        "\nPriors of light and vig are for a camera at {:.4g} cm: they follow --distance, by its square and "
        "by "
        "itself.\n",
        distance);
    return asJson ? JsonText(json, 2) + "\n" : text;
}

}  // namespace lacquer::cmd
