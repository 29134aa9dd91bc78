#include "cmd/render/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cmd/command_support.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {

namespace {

/// Unless an interval is asked for: seconds between checkpoints, and the largest part of the time for them.
constexpr double kInterval = 600, kLargestShare = 0.01;

}  // namespace

RenderCheckpoint::RenderCheckpoint(std::string resume, std::string path, std::optional<double> interval,
                                   Console* console)
    : resume_(std::move(resume)), path_(std::move(path)), interval_(interval), console_(console) {
    std::error_code error;
    if (!path_.empty() && std::filesystem::exists(path_, error) &&
        (resume_.empty() || !std::filesystem::equivalent(path_, resume_, error)))
        throw FileError(path_, fmt::format("is there already; to go on from it, add --resume {}; to begin "
                                           "anew, remove it",
                                           path_));
    if (!path_.empty()) {
        CheckOutputFile(path_);
        lock_.emplace(path_);
    }
    if (resume_.empty()) return;
    StateFile file = ReadStateFile(resume_);
    resumed_ = StateHeader::Read(resume_, file.header);
    stored_ = std::move(file.arrays);
}

std::optional<int> RenderCheckpoint::FilterSamples() const {
    if (resumed_) return resumed_->filterSamples;
    return {};
}

void RenderCheckpoint::Attach(StateHeader header, std::pair<int, int> range, const SampleShares* shares,
                              Film* film, AovBuffer* aovs) {
    header_ = std::move(header);
    range_ = range;
    shares_ = shares;
    film_ = film;
    aovs_ = aovs;
    if (!resumed_) return;
    std::string why = Difference(header_, *resumed_);
    if (!why.empty()) throw FileError(resume_, fmt::format("is the state of another render: {}", why));
    CheckSamples();
    std::vector<StateArray> arrays;
    film->AppendState(&arrays);
    if (aovs) aovs->AppendState("outputs: ", &arrays);
    why = AddState(stored_, arrays, header_.pixels, header_.pixels);
    if (!why.empty()) throw FileError(resume_, fmt::format("does not fit this render: {}", why));
    stored_.clear();
    header_.halfBlock = resumed_->halfBlock;
    header_.filterSamples = resumed_->filterSamples;
}

void RenderCheckpoint::CheckSamples() const {
    const auto refuse = [&](const std::string& why) {
        throw FileError(resume_, "is the state of another render: " + why);
    };
    if (resumed_->parts.size() != 1)
        refuse("it was merged of parts that are no one range of samples of all pixels");
    const StatePart& part = resumed_->parts[0];
    if (resumed_->pixels != header_.pixels || part.pixels != header_.pixels)
        refuse(fmt::format("\"pixelbounds\" is {} now and was {}", PixelsInWords(header_.pixels),
                           PixelsInWords(part.pixels)));
    if (part.first != range_.first)
        refuse(fmt::format("\"first of --sample-range\" is {} now and was {}", range_.first, part.first));
    if (part.least > range_.second - range_.first)
        throw FileError(resume_,
                        fmt::format("has {} samples in each pixel, more than the {} that are asked for",
                                    part.least, range_.second - range_.first));
}

void RenderCheckpoint::AddTo(RenderOptions* options) {
    if (!IsUsed()) return;
    options->halfBlock = header_.halfBlock;
    options->resumes = resumed_.has_value();
    if (path_.empty()) return;
    options->checkpointInterval = interval_.value_or(kInterval);
    if (!interval_) options->checkpointShare = kLargestShare;
    options->checkpoint = [this](double seconds) {
        // The next one may be better; the last one must be.
        try {
            Write(seconds);
        } catch (const FileError& e) {
            console_->Warn(e.Message());
        }
    };
}

void RenderCheckpoint::Write(double seconds) {
    const SampleSpan span = SampleSpanOf(film_->SampleCounts(), header_.pixels, shares_, range_.first);
    const int least = std::min(span.least, range_.second - range_.first);
    header_.parts = {{header_.pixels, range_.first, least, std::max(span.most, least)}};
    header_.seconds = SecondsBefore() + pilotSeconds_ + seconds;
    std::vector<StateArray> arrays;
    film_->AppendState(&arrays);
    if (aovs_) aovs_->AppendState("outputs: ", &arrays);
    WriteStateFile(path_, header_.Text(), arrays);
}

void RenderCheckpoint::Finish(double seconds, std::optional<int> samples) {
    if (samples) header_.samplesPerPixel = *samples;
    if (!path_.empty()) Write(seconds);
}

}  // namespace lacquer::cmd
