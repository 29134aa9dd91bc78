#include "capture/card/usable_tags.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "capture/card/card.h"
#include "pbrt/core/error.h"

namespace lacquer::capture {

namespace {

/// What makes a photograph useless before anyone looks where its tags are; empty if nothing does.
std::string ProblemOf(const TagDetection& detection) {
    if (detection.tags.empty() && detection.twice.empty()) {
        const std::string unknown = detection.unknown.empty() ? ""
                                                              : fmt::format(" but {}, which no card has",
                                                                            ListOfIds(detection.unknown));
        return fmt::format("no tags of the card are seen{}; expected the ids 0 to {}, sharp and not mirrored",
                           unknown, kNumTags - 1);
    }
    if (!detection.twice.empty())
        return fmt::format("tags are seen more than once: {}; expected one card", ListOfIds(detection.twice));
    if (!SurroundTheWindow(detection.tags))
        return fmt::format(
            "{} of the {} tags are seen, {} are missing; expected at least {}, at each corner of the "
            "card one of its three",
            detection.tags.size(), kNumTags, ListOfIds(detection.Missing()), kMinTags);
    return {};
}

UsableTags KeepConsistent(const std::vector<DetectedTag>& tags, double size) {
    const CardHomography card = FindCard(tags, size);
    UsableTags usable;
    usable.homography = card.matrix;
    for (size_t i = 0; i < tags.size(); ++i)
        if (std::find(card.consistent.begin(), card.consistent.end(), i) != card.consistent.end())
            usable.tags.push_back(tags[i]);
        else
            usable.rejected.push_back(tags[i].id);
    return usable;
}

void WarnOfTags(const CardPhotograph& photograph, const UsableTags& usable,
                std::vector<std::string>* warnings) {
    const std::vector<int> missing = photograph.detection.Missing();
    if (!missing.empty())
        warnings->push_back(
            fmt::format("{}: tags {} are not seen: the position of the camera is less certain",
                        photograph.name, ListOfIds(missing)));
    if (!usable.rejected.empty())
        warnings->push_back(fmt::format("{}: tags {} are not where the card has them, and do not count",
                                        photograph.name, ListOfIds(usable.rejected)));
    if (!photograph.detection.unknown.empty())
        warnings->push_back(fmt::format("{}: tags {} are of no card, and do not count", photograph.name,
                                        ListOfIds(photograph.detection.unknown)));
}

}  // namespace

std::string ListOfIds(const std::vector<int>& ids) {
    std::string text;
    for (size_t i = 0; i < ids.size(); ++i)
        text += (i == 0 ? "" : i + 1 == ids.size() ? " and " : ", ") + std::to_string(ids[i]);
    return text;
}

bool SurroundTheWindow(std::span<const DetectedTag> tags) {
    if (tags.size() < kMinTags) return false;
    std::array<bool, 4> corners{};
    for (const DetectedTag& tag : tags) {
        const Eigen::Vector2d c = TagCenter(tag.id);
        if (std::abs(c.x()) > 3 && std::abs(c.y()) > 3)
            corners[size_t(c.x() > 0) + 2 * size_t(c.y() > 0)] = true;
    }
    return std::all_of(corners.begin(), corners.end(), [](bool isSeen) { return isSeen; });
}

std::vector<UsableTags> FindUsableTags(std::span<const CardPhotograph> photographs, double size,
                                       std::vector<std::string>* warnings) {
    std::vector<UsableTags> result;
    std::vector<Diagnostic> problems;
    for (const CardPhotograph& photograph : photographs) {
        UsableTags usable;
        std::string problem = ProblemOf(photograph.detection);
        if (problem.empty()) {
            usable = KeepConsistent(photograph.detection.tags, size);
            if (!SurroundTheWindow(usable.tags))
                problem =
                    fmt::format("tags {} are not where the card has them; expected a print of this card",
                                ListOfIds(usable.rejected));
        }
        if (!problem.empty())
            problems.push_back({Diagnostic::Severity::Error, {photograph.name}, problem});
        else
            WarnOfTags(photograph, usable, warnings);
        result.push_back(std::move(usable));
    }
    if (!problems.empty()) throw SceneErrors(std::move(problems));
    return result;
}

}  // namespace lacquer::capture
