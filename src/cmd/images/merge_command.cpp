// lacquer merge: renders of one image with different samples become one.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/images/image_arguments.h"
#include "cmd/render/merge_states.h"
#include "pbrt/film/state_file.h"

namespace lacquer::cmd {
namespace {

/// Everything that the command line of `merge` can say.
struct MergeArguments {
    std::vector<std::string> images;
    std::string outfile, pixelBounds;
    bool quiet = false, isPartial = false;
};

/// The channel that counts the samples of each pixel.
constexpr const char *kSamples = "samples", *kHalfSamples = "Half.samples";

/// How a channel of several images becomes one.
enum class Rule {
    Mean,       ///< mean over the samples
    Direction,  ///< a component of a mean direction, which is normalised in the end
    Variance,   ///< sample variance of the luminance
    Count,      ///< number of samples
    Half,       ///< mean over the first half of the samples
    HalfCount,  ///< number of samples in the first half
};

Rule RuleOf(const std::string& channel) {
    if (channel == kSamples) return Rule::Count;
    if (channel == kHalfSamples) return Rule::HalfCount;
    if (channel == "Variance.Y") return Rule::Variance;
    if (channel.starts_with("N.") || channel.starts_with("Ns.")) return Rule::Direction;
    return channel.starts_with("Half.") ? Rule::Half : Rule::Mean;
}

/// Means over the samples that hit something, whose number no file tells.
bool IsMeanOverHits(const std::string& channel) {
    return RuleOf(channel) == Rule::Direction || channel.starts_with("P.") ||
           channel.starts_with("motion.") || channel == "Z" || channel == "u" || channel == "v" ||
           channel == "dzdx" || channel == "dzdy";
}

/// Variances of the film gbuffer, which do not say of what mean.
bool IsVarianceOverHits(const std::string& channel) {
    return channel.starts_with("RelativeVariance.") ||
           (channel.starts_with("Variance.") && RuleOf(channel) != Rule::Variance);
}

/// Names as numbers: ids of objects and materials, and the ranks of Cryptomatte.
bool HoldsIds(const std::string& channel) {
    return channel.starts_with("Crypto") || channel == "object.id" || channel == "material.id";
}

/// One input.
struct Part {
    std::string path;
    Image image;
    std::vector<int>
        channels;  ///< index of each channel of the result; -1 for numbers of samples that are not there
    int samplesPerPixel = 0;  ///< of all pixels; 0: the channel "samples" tells
    /// Samples of a pixel.
    double Count(size_t pixel) const {
        if (samplesPerPixel > 0) return samplesPerPixel;
        return double(
            image.Pixels()[pixel * size_t(image.NumChannels()) + size_t(image.FindChannel(kSamples))]);
    }
    /// Of them in the first half: one more of an odd number, where no channel tells.
    double HalfCount(size_t pixel) const {
        const int c = image.FindChannel(kHalfSamples);
        return c < 0 ? std::ceil(Count(pixel) / 2)
                     : double(image.Pixels()[pixel * size_t(image.NumChannels()) + size_t(c)]);
    }
    float Value(size_t pixel, size_t channel) const {
        return image.Pixels()[pixel * size_t(image.NumChannels()) + size_t(channels[channel])];
    }
};

size_t NumPixels(const Image& image) { return image.Pixels().size() / size_t(image.NumChannels()); }

/// What an int can hold, as a number of samples.
constexpr double kMaxCount = std::numeric_limits<int>::max();

class MergeJob {
  public:
    explicit MergeJob(const MergeArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    ExitStatus Run() {
        if (a_.images.size() < 2) throw CLI::ValidationError("merge: at least two images are expected");
        CheckImageOutput(a_.outfile);
        for (const std::string& path : a_.images) Read(path);
        WarnOfSharedSamples();
        WarnOfHits();
        Merge();
        MergeMetadata();
        WarnOfNonFinite(result_, a_.outfile, &console_);
        WriteImage(result_, a_.outfile, parts_[0].image.format == PixelFormat::Half);
        console_.Info(fmt::format("{}: {} images, {} samples per pixel", a_.outfile, parts_.size(),
                                  perPixel_.first == perPixel_.second
                                      ? fmt::format("{}", perPixel_.first)
                                      : fmt::format("{} to {}", perPixel_.first, perPixel_.second)));
        return ExitStatus::Complete;
    }

  private:
    void Read(const std::string& path) {
        Part part{path, ReadImageArgument(path), {}, 0};
        const Image& first = parts_.empty() ? part.image : parts_[0].image;
        std::string why = Mismatch(first, part.image);
        if (why.empty()) why = ChannelMismatch(first, part.image, kSamples);
        if (!why.empty())
            throw FileError(path, fmt::format("cannot be merged with {}: {}", parts_[0].path, why));
        for (const std::string& channel : part.image.Channels())
            if (HoldsIds(channel))
                throw FileError(path, fmt::format("its channel \"{}\" holds ids, which have no average; "
                                                  "render the parts without them",
                                                  channel));
        if (part.image.FindChannel(kSamples) < 0) {
            part.samplesPerPixel = IntMetadata(part.image, "samplesPerPixel").value_or(0);
            if (part.samplesPerPixel < 1)
                throw FileError(path,
                                "does not say how many samples it has: no channel \"samples\" (render with "
                                "--aov samples) and no metadata \"samplesPerPixel\"");
        } else {
            CheckCounts(part);
        }
        parts_.push_back(std::move(part));
    }

    static void CheckCounts(const Part& part) {
        for (size_t i = 0; i < NumPixels(part.image); ++i)
            if (const double count = part.Count(i); !(count >= 0) || std::isinf(count))
                throw FileError(part.path, fmt::format("its channel \"samples\" says {}", count));
    }

    /// The same samples twice look like more samples, but are not.
    void WarnOfSharedSamples() {
        for (size_t i = 0; i < parts_.size(); ++i)
            for (size_t j = 0; j < i; ++j) {
                const std::string both = fmt::format("{} and {}", parts_[j].path, parts_[i].path);
                const auto seed = IntMetadata(parts_[i].image, "seed");
                if (!seed || seed != IntMetadata(parts_[j].image, "seed")) continue;
                const auto a = SamplesOf(parts_[i]), b = SamplesOf(parts_[j]);
                if (!a || !b)
                    console_.Warn(
                        fmt::format("{} have one seed, {}, and do not say which samples they hold; "
                                    "if these are the same, nothing is gained",
                                    both, *seed));
                else if (a->first < b->second && b->first < a->second)
                    console_.Warn(fmt::format(
                        "{} have one seed, {}, and share samples {} to {}: these count twice", both, *seed,
                        std::max(a->first, b->first), std::min(a->second, b->second) - 1));
            }
    }

    /// First sample, and one behind the last that some pixel has.
    static std::optional<std::pair<int, int>> SamplesOf(const Part& part) {
        const auto first = IntMetadata(part.image, "firstSample");
        if (!first) return {};
        double most = 0;
        for (size_t i = 0; i < NumPixels(part.image); ++i) most = std::max(most, part.Count(i));
        return std::pair(*first, int(std::min(*first + most, kMaxCount)));
    }

    void WarnOfHits() {
        WarnOf(IsMeanOverHits,
               "{} are means over the samples that hit something, whose number the files do not tell: at the "
               "edges of objects the result is approximate");
        WarnOf(IsVarianceOverHits,
               "{}: the mean of the parts' variances, which knows nothing of how the parts differ from each "
               "other");
    }

    /// @param warning  with a {} for the names of such channels
    void WarnOf(bool (*isSuch)(const std::string&), fmt::format_string<std::string> warning) {
        std::vector<std::string> names;
        for (const std::string& channel : parts_[0].image.Channels())
            if (isSuch(channel)) names.push_back(channel);
        if (!names.empty()) console_.Warn(fmt::format(warning, fmt::format("{}", fmt::join(names, ", "))));
    }

    void Merge() {
        const Image& first = parts_[0].image;
        std::vector<std::string> channels = first.Channels();
        const auto counts = [](const Part& part) { return part.image.FindChannel(kSamples) >= 0; };
        if (std::any_of(parts_.begin(), parts_.end(), counts) && !counts(parts_[0]))
            channels.emplace_back(kSamples);
        // Halves of different numbers of samples: the result has to tell their number, even if no part does.
        if (first.FindChannel("Half.R") >= 0 && first.FindChannel(kHalfSamples) < 0)
            channels.emplace_back(kHalfSamples);
        for (Part& part : parts_)
            for (const std::string& channel : channels)
                part.channels.push_back(part.image.FindChannel(channel));
        result_ = Image(first.Resolution(), channels);
        result_.dataWindow = first.dataWindow;
        result_.fullResolution = first.fullResolution;
        result_.SetColorSpace(first.ColorSpace());
        for (const std::string& channel : channels)
            wholes_.push_back(RuleOf(channel) == Rule::Half ? result_.FindChannel(channel.substr(5)) : -1);
        perPixel_ = {std::numeric_limits<double>::infinity(), 0};
        for (size_t i = 0; i < NumPixels(first); ++i) MergePixel(i);
    }

    void MergePixel(size_t pixel) {
        const std::vector<std::string>& channels = result_.Channels();
        double count = 0;
        for (const Part& part : parts_) count += part.Count(pixel);
        perPixel_ = {std::min(perPixel_.first, count), std::max(perPixel_.second, count)};
        float* out = result_.Pixels().data() + pixel * channels.size();
        for (size_t c = 0; c < channels.size(); ++c) {
            const Rule rule = RuleOf(channels[c]);
            double value = 0;
            if (rule == Rule::Count) value = count;
            if (rule == Rule::Variance) value = PooledVariance(pixel, c, count);
            if (rule == Rule::Mean || rule == Rule::Direction) value = Mean(pixel, c, count);
            if (rule == Rule::Half) value = HalfMean(pixel, c);
            if (rule == Rule::HalfCount) value = HalfCount(pixel);
            out[c] = float(value);
        }
        NormalizeDirection(out, "N.X");
        NormalizeDirection(out, "Ns.X");
        NormalizeDirection(out, "Half.Ns.X");
    }

    double Mean(size_t pixel, size_t channel, double count) const {
        double sum = 0;
        for (const Part& part : parts_)
            // Nothing is known of a pixel without samples, whatever stands there.
            if (const double n = part.Count(pixel); n > 0) sum += n * double(part.Value(pixel, channel));
        return count > 0 ? sum / count : 0;
    }

    /// Calls `add(part, n, first, changes)` for the parts with samples, n of them and `first` in the first
    /// half. Parts change their halves where that makes those of the result more even: of single samples all
    /// would be in the first one.
    template <class Add>
    void ForHalves(size_t pixel, const Add& add) const {
        double count = 0, total = 0;
        for (const Part& part : parts_) {
            const double n = part.Count(pixel), first = part.HalfCount(pixel);
            if (n <= 0) continue;
            const bool changes = first > n - first && 2 * count > total;
            add(part, n, first, changes);
            count += changes ? n - first : first;
            total += n;
        }
    }

    double HalfCount(size_t pixel) const {
        double count = 0;
        ForHalves(pixel, [&](const Part&, double n, double first, bool changes) {
            count += changes ? n - first : first;
        });
        return count;
    }

    /// Where the result lacks the channel of all samples, no part can change its halves; no denoiser takes
    /// those.
    double HalfMean(size_t pixel, size_t channel) const {
        double sum = 0, count = 0;
        ForHalves(pixel, [&](const Part& part, double n, double first, bool changes) {
            changes &= wholes_[channel] >= 0;
            // Nothing is known of a half without samples, whatever stands there.
            const double ofFirst = first > 0 ? first * double(part.Value(pixel, channel)) : 0;
            sum += changes ? n * double(part.Value(pixel, size_t(wholes_[channel]))) - ofFirst : ofFirst;
            count += changes ? n - first : first;
        });
        return count > 0 ? sum / count : 0;
    }

    /// Sample variance of all samples from those of the parts, by sums of squared deviations [Chan et al.
    /// 1983]: those within the parts, and those of the parts' means, whose luminance the colours tell.
    double PooledVariance(size_t pixel, size_t channel, double count) const {
        if (count < 2) return 0;
        double mean = 0;
        for (const Part& part : parts_) mean += part.Count(pixel) * Luminance(part, pixel) / count;
        double deviations = 0;
        for (const Part& part : parts_) {
            const double n = part.Count(pixel);
            if (n <= 0) continue;
            deviations += (n - 1) * double(part.Value(pixel, channel));
            deviations += n * Sqr(Luminance(part, pixel) - mean);
        }
        return deviations / (count - 1);
    }

    double Luminance(const Part& part, size_t pixel) const {
        if (!result_.HasRGB())
            throw FileError(part.path,
                            "the variances of images without channels R, G and B cannot be merged");
        const RGB rgb(part.Value(pixel, 0), part.Value(pixel, 1), part.Value(pixel, 2));
        return double(result_.ColorSpace()->Luminance(rgb));
    }

    /// The three channels from `x` on, which stand side by side as X, Y, Z.
    void NormalizeDirection(float* pixel, const char* x) const {
        const int c = result_.FindChannel(x);
        if (c < 0 || c + 3 > result_.NumChannels()) return;
        const Vec3 v(pixel[c], pixel[c + 1], pixel[c + 2]);
        const float length = Length(v);
        for (int i = 0; i < 3 && length > 0; ++i) pixel[c + i] = v[i] / length;
    }

    /// What is the same in all stays; what can be added is; where samples begin is known while they are
    /// gapless.
    void MergeMetadata() {
        result_.metadata = parts_[0].image.metadata;
        for (const Part& part : parts_)
            std::erase_if(result_.metadata, [&](const auto& entry) {
                const auto it = part.image.metadata.find(entry.first);
                return it == part.image.metadata.end() || it->second != entry.second;
            });
        for (const char* name : {"samplesPerPixel", "firstSample", "renderTimeSeconds"})
            result_.metadata.erase(name);
        AddCounts();
        AddFirstSample();
    }

    void AddCounts() {
        int64_t count = 0;
        float seconds = 0;
        bool counted = true, timed = true;
        for (const Part& part : parts_) {
            const auto samples = IntMetadata(part.image, "samplesPerPixel");
            counted = counted && samples;
            count += samples.value_or(0);
            const auto it = part.image.metadata.find("renderTimeSeconds");
            const float* time = it == part.image.metadata.end() ? nullptr : std::get_if<float>(&it->second);
            timed = timed && time;
            seconds += time ? *time : 0;
        }
        if (counted && double(count) <= kMaxCount) result_.metadata["samplesPerPixel"] = int(count);
        if (timed) result_.metadata["renderTimeSeconds"] = seconds;
    }

    void AddFirstSample() {
        if (!result_.metadata.contains("seed")) return;
        std::vector<std::pair<int, int>> ranges;
        for (const Part& part : parts_) {
            const auto range = SamplesOf(part);
            // Of a time limit, some pixels have more samples than others: no range fits all.
            const auto all = IntMetadata(part.image, "samplesPerPixel");
            if (!range || !all || range->second != range->first + *all) return;
            ranges.push_back(*range);
        }
        std::sort(ranges.begin(), ranges.end());
        for (size_t i = 1; i < ranges.size(); ++i)
            if (ranges[i].first != ranges[i - 1].second) return;
        result_.metadata["firstSample"] = ranges[0].first;
    }

    const MergeArguments& a_;
    Console console_;
    std::vector<Part> parts_;
    Image result_;
    std::vector<int> wholes_;  ///< of each channel of a half, that of all samples; -1: there is none
    std::pair<double, double> perPixel_;  ///< least and most samples
};

void AddMergeOptions(CLI::App& app, MergeArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    app.add_option("images", a.images, "Images of one scene, or states (render --checkpoint) of one render")
        ->type_name(kFile)
        ->required()
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--outfile", a.outfile,
                   "Image to write; the extension chooses the format. Of states also NAME.state")
        ->type_name(kFile)
        ->required();
    app.add_flag("--partial", a.isPartial, "Of states: samples may be missing");
    app.add_option("--pixelbounds", a.pixelBounds,
                   "x0,x1,y0,y1: of states of a part of the image, the pixels that are wanted");
    app.add_flag("--quiet", a.quiet, "No information and no warnings");
}

/// All are states, or none is. Errors: usage.
bool AreStates(const MergeArguments& a) {
    const auto states = std::count_if(a.images.begin(), a.images.end(), IsStateFile);
    const auto other = std::find_if_not(a.images.begin(), a.images.end(), IsStateFile);
    // What cannot be read is reported by who reads it.
    if (states > 0 && other != a.images.end() && std::filesystem::exists(*other))
        throw CLI::ValidationError(
            fmt::format("merge: {} is no state; either all files are states or none is", *other));
    if (states == 0 && (a.isPartial || !a.pixelBounds.empty()))
        throw CLI::ValidationError("merge: --partial and --pixelbounds are for states");
    return states > 0;
}

std::optional<Bounds2i> PixelBoundsOf(const std::string& text) {
    if (text.empty()) return {};
    std::istringstream in(text);
    Bounds2i b;
    std::array<char, 3> commas{};
    char rest = 0;
    in >> b.min.x >> commas[0] >> b.max.x >> commas[1] >> b.min.y >> commas[2] >> b.max.y;
    if (!in || commas != std::array{',', ',', ','} || in >> rest || b.IsEmpty())
        BadOption("pixelbounds", text, "x0,x1,y0,y1 in pixels, at least one of them");
    return b;
}

ExitStatus RunMerge(const MergeArguments& arguments) {
    if (!AreStates(arguments)) return MergeJob(arguments).Run();
    const StateMerge merge{arguments.images, arguments.outfile, arguments.isPartial,
                           PixelBoundsOf(arguments.pixelBounds)};
    Console console(ConsoleStyle::Detect(arguments.quiet));
    return MergeStates(merge, &console);
}

constexpr const char* kMergeSynopsis =
    "Averages renders of one image, each with the weight of its samples. Of states, all parts of a render,\n"
    "the exact sum: the same bits as one render.";
constexpr const char* kMergeFooter = R"(
Exit status: 0 all is done; 1 wrong usage; 3 a file cannot be read or written, or does not fit.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "merge", (CommandOf<MergeArguments, AddMergeOptions, RunMerge>::Make),
                 {.synopsis = kMergeSynopsis, .footer = kMergeFooter});

}  // namespace lacquer::cmd
