// lacquer diff: how far an image is from a reference.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "cmd/choices.h"
#include "cmd/command.h"
#include "cmd/command_support.h"
#include "cmd/console.h"
#include "cmd/images/image_arguments.h"
#include "cmd/printable.h"
#include "cmd/version.h"
#include "compare/color_map.h"
#include "compare/flip.h"
#include "compare/metrics.h"
#include "pbrt/core/parallel.h"

namespace lacquer::cmd {
namespace {

/// Everything that the command line of `diff` can say.
struct DiffArguments {
    std::string image, reference;
    std::string metric = "RMSE";
    std::vector<std::string> boxes;
    std::vector<std::string> channels;  ///< none: all
    std::optional<double> tolerance;
    std::string outfile;
    int threads = 0;
    bool quiet = false;
};

/// Exit statuses: those of OpenImageIO's idiff, which uses 1 for wrong usage, as Lacquer does, and for
/// warnings, of which this command has none.
enum class DiffStatus : int {
    Match = 0,          ///< measured; within the tolerance if there is one
    Usage = 1,          ///< the command line makes no sense
    Failure = 2,        ///< above the tolerance, or NaN or infinite values
    DifferentSize = 3,  ///< sizes, channels or colour spaces that cannot be compared
    File = 4,           ///< a file cannot be read or written
};

constexpr const char* kFlip = "FLIP";
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// The errors of one part of the image.
struct Row {
    compare::Box box;  ///< in the image's own pixels
    double mean;       ///< over R, G and B if they are there, else over all channels
    std::vector<double> channels;
};

class DiffJob {
  public:
    explicit DiffJob(const DiffArguments& arguments)
        : a_(arguments), console_(ConsoleStyle::Detect(arguments.quiet)) {}

    DiffStatus Run() {
        if (a_.tolerance && !(*a_.tolerance >= 0))
            throw CLI::ValidationError(
                fmt::format("--tolerance {}: expected a number of at least 0", *a_.tolerance));
        const ThreadLimit threads(a_.threads);
        try {
            if (!a_.outfile.empty()) CheckImageOutput(a_.outfile);
            image_ = ReadImageArgument(a_.image);
            reference_ = ReadImageArgument(a_.reference);
            if (const std::string why = Incomparable(); !why.empty()) {
                console_.Error(
                    fmt::format("{}: cannot be compared with {}: {}", a_.image, a_.reference, why));
                return DiffStatus::DifferentSize;
            }
            return Compare();
        } catch (const FileError& e) {
            console_.Error(
                Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::File});
            return DiffStatus::File;
        }
    }

  private:
    bool IsFlip() const { return a_.metric == kFlip; }
    compare::Metric PixelMetric() const {
        return IsFlip() ? compare::Metric::MAE : *compare::ParseMetric(a_.metric);
    }

    /// Chooses the channels, too.
    std::string Incomparable() {
        for (const std::string& channel : a_.channels) {
            CheckName("--channels", channel, reference_.Channels());
            if (image_.FindChannel(channel) < 0) return fmt::format("it has no channel {}", channel);
        }
        if (IsFlip() && (!image_.HasRGB() || !reference_.HasRGB()))
            return "FLIP compares colours, and one of them has no channels R, G, B";
        channels_ = IsFlip() ? std::vector<std::string>{"R", "G", "B"} : a_.channels;
        const bool all = channels_.empty();
        if (all) channels_ = reference_.Channels();
        const std::string why = Mismatch(reference_, image_);
        return why.empty() && all ? ChannelMismatch(reference_, image_) : why;
    }

    DiffStatus Compare() {
        std::vector<compare::Box> boxes{{"all", {{0, 0}, image_.Resolution()}}};
        for (const std::string& text : a_.boxes) boxes.push_back(BoxOfImage("--box", text, reference_));
        const bool finite = ReportNonFinite();
        MakeMap(finite);
        if (!a_.outfile.empty()) WriteMap();
        std::vector<Row> rows;
        for (const compare::Box& box : boxes) rows.push_back(Measure(box));
        Print(rows);
        if (!finite) return DiffStatus::Failure;
        return WithinTolerance(rows) ? DiffStatus::Match : DiffStatus::Failure;
    }

    /// True if there is nothing to report.
    bool ReportNonFinite() {
        bool finite = true;
        for (const auto& [image, path] :
             {std::pair(&image_, &a_.image), std::pair(&reference_, &a_.reference)}) {
            const compare::NonFinite found = compare::FindNonFinite(*image, channels_);
            if (!found.Any()) continue;
            finite = false;
            const Int2 place = found.pixel + image->Window().min;
            console_.Error(fmt::format("{}: {} values are NaN and {} infinite; the first is {} at x {}, y {}",
                                       *path, found.nan, found.inf, found.channel, place.x, place.y));
        }
        return finite;
    }

    void MakeMap(bool finite) {
        if (!IsFlip()) {
            map_ = compare::ErrorMap(image_, reference_, PixelMetric(), channels_);
            return;
        }
        const bool isScreen = image_.format == PixelFormat::Byte && reference_.format == PixelFormat::Byte;
        metricName_ = isScreen ? "LDR-FLIP" : "HDR-FLIP";
        if (!finite) {
            // Its filters would carry what is not finite over a good part of the image.
            map_ = Image(image_.Resolution(), {"FLIP"});
            std::fill(map_.Pixels().begin(), map_.Pixels().end(), float(kNaN));
        } else {
            map_ = isScreen ? compare::LdrFlip(image_, reference_)
                            : HdrFlip(image_, reference_, compare::HdrFlipExposures(reference_));
        }
    }

    /// The columns that `mean` is the mean of.
    std::vector<int> MeanChannels() const {
        std::vector<int> chosen;
        for (const char* name : {"R", "G", "B"})
            if (const int c = map_.FindChannel(name); c >= 0) chosen.push_back(c);
        if (chosen.size() == 3) return chosen;
        chosen.clear();
        for (int c = 0; c < map_.NumChannels(); ++c) chosen.push_back(c);
        return chosen;
    }

    Row Measure(const compare::Box& box) const {
        Row row{box, 0, compare::ErrorOver(map_, PixelMetric(), box.pixels)};
        std::vector<double> chosen;
        for (const int c : MeanChannels()) chosen.push_back(row.channels[size_t(c)]);
        row.mean = compare::MeanOfErrors(chosen, PixelMetric());
        return row;
    }

    void Print(const std::vector<Row>& rows) const {
        fmt::print("metric\tregion\tx0\tx1\ty0\ty1\tmean");
        if (!IsFlip())
            for (const std::string& channel : channels_) fmt::print("\t{}", PrintableName(channel));
        fmt::print("\n");
        const Int2 corner = reference_.Window().min;
        for (const Row& row : rows) {
            const Bounds2i& p = row.box.pixels;
            std::string name = row.box.name;
            std::replace_if(
                name.begin(), name.end(), [](char c) { return std::iscntrl((unsigned char)c); }, ' ');
            fmt::print("{}\t{}\t{}\t{}\t{}\t{}\t{:.9g}", metricName_, name, p.min.x + corner.x,
                       p.max.x + corner.x, p.min.y + corner.y, p.max.y + corner.y, row.mean);
            if (!IsFlip())
                for (const double error : row.channels) fmt::print("\t{:.9g}", error);
            fmt::print("\n");
        }
        std::fflush(stdout);
    }

    bool WithinTolerance(const std::vector<Row>& rows) {
        if (!a_.tolerance) return true;
        int above = 0;
        double largest = 0;
        std::string where;
        const auto check = [&](double error, const std::string& what) {
            if (error <= *a_.tolerance) return;
            ++above;
            if (error > largest) where = what;
            largest = std::max(largest, error);
        };
        for (const Row& row : rows) {
            check(row.mean, row.box.name + ", mean");
            for (size_t c = 0; c < row.channels.size() && !IsFlip(); ++c)
                check(row.channels[c], row.box.name + ", " + channels_[c]);
        }
        if (above == 0) return true;
        console_.Error(
            fmt::format("{} of {} is above the tolerance of {} in {} number{}; the largest is {:.6g} ({})",
                        metricName_, a_.image, *a_.tolerance, above, above == 1 ? "" : "s", largest, where));
        return false;
    }

    void WriteMap() {
        const bool isRaw = !HoldsBytes(a_.outfile);
        float largest = 0;
        Image map = isRaw ? map_ : ColoredMap(&largest);
        map.metadata["metric"] = metricName_;
        map.metadata["Software"] = fmt::format("Lacquer {}", kVersion);
        WriteImage(map, a_.outfile);
        if (isRaw) return;
        const bool isDifference = !IsFlip() && PixelMetric() == compare::Metric::RMSE;
        console_.Info(fmt::format("{}: {} of each pixel, black is 0, pale yellow {:.6g}", a_.outfile,
                                  isDifference ? "|difference|" : metricName_, largest));
    }

    /// The mean of each pixel's channels in colours: FLIP from 0 to 1, all else from 0 to `*largest`.
    Image ColoredMap(float* largest) const {
        const std::vector<int> chosen = MeanChannels();
        std::vector<float> errors;
        *largest = IsFlip() ? 1.f : 0.f;
        for (size_t i = 0; i < map_.Pixels().size(); i += size_t(map_.NumChannels())) {
            double sum = 0;
            for (const int c : chosen) sum += double(map_.Pixels()[i + size_t(c)]);
            errors.push_back(float(sum / double(chosen.size())));
            if (std::isfinite(errors.back())) *largest = std::max(*largest, errors.back());
        }
        Image colored = compare::ColoredErrors(errors, map_.Resolution(), *largest);
        colored.dataWindow = map_.dataWindow;
        colored.fullResolution = map_.fullResolution;
        return colored;
    }

    const DiffArguments& a_;
    Console console_;
    Image image_, reference_, map_;
    std::vector<std::string> channels_;
    std::string metricName_ = a_.metric;
};

void AddDiffOptions(CLI::App& app, DiffArguments& a) {
    app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
    std::vector<std::string> metrics = compare::MetricNames();
    metrics.emplace_back(kFlip);
    app.add_option("image", a.image, "The image to judge")->type_name(kFile)->required();
    app.add_option("reference", a.reference, "What it should be")->type_name(kFile)->required();
    app.add_option("--metric", a.metric, "What is measured")->check(OneOf(metrics))->capture_default_str();
    app.add_option("--box", a.boxes, "NAME:x0,x1,y0,y1: a part to measure as well, in fractions or pixels")
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--channels", a.channels, "Only these channels, with commas between; default: all")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    app.add_option("--tolerance", a.tolerance, "Largest number of the table that is no failure");
    app.add_option("--outfile", a.outfile,
                   "The error of each pixel: values in .exr, .tif, .pfm and .hdr, colours in other formats")
        ->type_name(kFile);
    app.add_option("--nthreads", a.threads, "Threads; 0: all processors")->check(CLI::Range(0, 1024));
    app.add_flag("--quiet", a.quiet, "No information beside the table");
}

DiffStatus RunDiff(const DiffArguments& arguments) { return DiffJob(arguments).Run(); }

constexpr const char* kDiffSynopsis = "Measures how far an image is from a reference.";
constexpr const char* kDiffFooter = R"(
Prints a line with the names of the columns and one for the whole and each box, with tabs between.
Exit status, as of idiff: 0 measured, and within the tolerance if there is one; 1 wrong usage; 2 above the
tolerance, or values that are NaN or infinite; 3 sizes, channels or colour spaces differ; 4 a file cannot
be read or written.)";

}  // namespace

LACQUER_REGISTER(CommandKind, "diff", (CommandOf<DiffArguments, AddDiffOptions, RunDiff>::Make),
                 {.synopsis = kDiffSynopsis, .footer = kDiffFooter});

}  // namespace lacquer::cmd
