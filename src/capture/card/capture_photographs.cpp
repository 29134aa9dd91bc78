#include "capture/card/capture_photographs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <stdexcept>

#include "capture/card/photograph.h"
#include "capture/card/rectify.h"
#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"
#include "pbrt/core/parallel.h"

namespace lacquer::capture {

namespace {

/// Share of the sample that may be clipped without a warning.
constexpr double kManyClipped = 0.05;
constexpr int kMaxRectifiedSide = 8192;
constexpr size_t kMaxFileBytes = size_t(1) << 32;

void CheckOptions(const CaptureOptions& options) {
    const auto refuse = [](const std::string& message) { throw std::invalid_argument(message); };
    if (!(options.size >= kMinCardSize && options.size <= kMaxCardSize))
        refuse(fmt::format("the card has a size of {} cm; expected {} to {}", options.size, kMinCardSize,
                           kMaxCardSize));
    if (!(options.depth >= 0 && options.depth < options.size))
        refuse(fmt::format("the sample lies {} cm below the card; expected 0 to its size", options.depth));
    if (!(options.sampleShare > 0 && options.sampleShare <= kWindowUnits / kUnitsPerSize))
        refuse(fmt::format(
            "{} of the card's size is to be cut out; expected more than 0 and at most {:.3g}, its window",
            options.sampleShare, kWindowUnits / kUnitsPerSize));
    if (options.resolution < 1 || options.resolution > kMaxRectifiedSide)
        refuse(fmt::format("a resolution of {}; expected 1 to {}", options.resolution, kMaxRectifiedSide));
    if (options.focal && !(*options.focal > 0 && std::isfinite(*options.focal)))
        refuse(fmt::format("a focal length of {} pixels; expected a positive number", *options.focal));
    for (const double x : options.flash)
        if (!std::isfinite(x)) refuse("the flash has no finite position");
}

/// What is kept of a file between its two readings.
struct FileFacts {
    Int2 resolution{0};
    std::optional<double> focal35mm, exposure;
    TagDetection detection;
    uint64_t hash = 0;
};

class Capture {
  public:
    Capture(const std::vector<std::string>& files, const CaptureOptions& options)
        : files_(files), options_(options) {}

    CapturedPhotographs Run() {
        CheckOptions(options_);
        facts_.resize(files_.size());
        ForEachFile([this](size_t i) { Detect(i); });
        CheckSizes();
        RefuseTwins();
        CalibrateCameras();
        result_.photographs.resize(files_.size());
        EqualizeExposures();
        ForEachFile([this](size_t i) { RectifyFile(i); });
        MakeViews();
        WarnOfPixels();
        return std::move(result_);
    }

  private:
    /// All files that cannot be used are reported, in their order.
    void ForEachFile(const std::function<void(size_t)>& body) const {
        std::vector<std::optional<Diagnostic>> problems(files_.size());
        ParallelFor(int64_t(files_.size()), [&](int64_t i) {
            try {
                body(size_t(i));
            } catch (const SceneError& e) {
                problems[size_t(i)] = {Diagnostic::Severity::Error, e.Loc(), e.Message()};
            } catch (const FileError& e) {
                problems[size_t(i)] = {
                    Diagnostic::Severity::Error, {e.Path()}, e.Problem(), Diagnostic::Cause::File};
            }
        });
        std::vector<Diagnostic> found;
        for (const auto& problem : problems)
            if (problem) found.push_back(*problem);
        if (!found.empty()) throw SceneErrors(std::move(found));
    }

    void Detect(size_t i) {
        const PhotographFile file = ReadPhotographFile(files_[i], options_.response);
        facts_[i] = {file.linear.Resolution(), file.focal35mm, file.exposure, DetectTags(GreyOf(file.linear)),
                     HashOfBytes(ReadFileBytes(files_[i], {}, {.maxBytes = kMaxFileBytes}).View())};
    }

    /// A photograph that is given twice counts twice, and judges itself where one of the two is held out.
    void RefuseTwins() const {
        std::vector<Diagnostic> problems;
        for (size_t i = 0; i < files_.size(); ++i)
            for (size_t k = 0; k < i; ++k) {
                if (facts_[i].hash != facts_[k].hash) continue;
                problems.push_back(
                    {Diagnostic::Severity::Error,
                     {files_[i]},
                     fmt::format("is the same photograph as {}; expected each one once", files_[k])});
                break;
            }
        if (!problems.empty()) throw SceneErrors(std::move(problems));
    }

    void CheckSizes() const {
        std::vector<Diagnostic> problems;
        for (size_t i = 1; i < files_.size(); ++i)
            if (const Int2 a = facts_[0].resolution, b = facts_[i].resolution; a != b)
                problems.push_back(
                    {Diagnostic::Severity::Error,
                     {files_[i]},
                     fmt::format("the photograph has {} x {} pixels, {} has {} x {}; expected one camera "
                                 "at one zoom",
                                 b.x, b.y, files_[0], a.x, a.y)});
        if (!problems.empty()) throw SceneErrors(std::move(problems));
    }

    void CalibrateCameras() {
        std::vector<CardPhotograph> photographs;
        for (size_t i = 0; i < files_.size(); ++i) photographs.push_back({files_[i], facts_[i].detection});
        CalibrationOptions options;
        options.size = options_.size;
        if (!facts_.empty()) options.resolution = result_.resolution = facts_[0].resolution;
        options.focal = options_.focal;
        for (const FileFacts& facts : facts_) {
            if (!facts.focal35mm) continue;
            const double focal = FocalInPixels(*facts.focal35mm, facts.resolution);
            if (options.focalOfMetadata && std::abs(focal / *options.focalOfMetadata - 1) > 0.01)
                result_.warnings = {
                    "the photographs' metadata have different focal lengths; expected one zoom"};
            if (!options.focalOfMetadata) options.focalOfMetadata = focal;
        }
        result_.calibration = Calibrate(photographs, options);
        const Calibration& found = result_.calibration;
        result_.warnings.insert(result_.warnings.end(), found.warnings.begin(), found.warnings.end());
    }

    void EqualizeExposures() {
        double darkest = std::numeric_limits<double>::max(), brightest = 0;
        size_t numKnown = 0;
        for (const FileFacts& facts : facts_)
            if (facts.exposure) {
                ++numKnown;
                darkest = std::min(darkest, *facts.exposure);
                brightest = std::max(brightest, *facts.exposure);
            }
        if (numKnown > 0 && numKnown < files_.size() && files_.size() > 1)
            result_.warnings.push_back(
                fmt::format("only {} of the {} photographs tell their exposure: all are taken for "
                            "equally exposed",
                            numKnown, files_.size()));
        // A third of a stop is the step of cameras; less is rounding.
        if (numKnown < files_.size() || brightest < 1.02 * darkest) return;
        for (size_t i = 0; i < files_.size(); ++i) {
            const double factor = darkest / *facts_[i].exposure;
            result_.photographs[i].exposureFactor = factor;
            if (factor < 1)
                result_.notes.push_back(
                    fmt::format("{}: exposed {:.3g} times as much as the darkest one, which is "
                                "divided out",
                                files_[i], 1 / factor));
        }
    }

    double SquareSize() const { return options_.sampleShare * options_.size; }

    void RectifyFile(size_t i) {
        const PhotographFile file = ReadPhotographFile(files_[i], options_.response);
        if (file.linear.Resolution() != facts_[i].resolution)
            throw SceneError({files_[i]}, "the file has changed while it was read");
        CapturedPhotograph& photograph = result_.photographs[i];
        photograph.file = files_[i];
        photograph.detection = facts_[i].detection;
        photograph.pose = result_.calibration.photographs[i];
        RectifiedPhotograph rectified =
            Rectify(file.linear, result_.calibration.intrinsics, photograph.pose.pose,
                    {SquareSize(), options_.depth, options_.resolution, file.clipped});
        photograph.clippedShare = rectified.clippedShare;
        photograph.outsideShare = rectified.outsideShare;
        for (float& v : rectified.linear.Pixels()) v *= float(photograph.exposureFactor);
        photograph.rectified = std::move(rectified.linear);
    }

    void MakeViews() {
        result_.views.size = SquareSize();
        result_.views.response = options_.response;
        const Eigen::Vector3d flash(options_.flash[0], -options_.flash[1], options_.flash[2]);  // y down
        const Eigen::Vector3d up(0, 0, options_.depth);
        for (size_t i = 0; i < files_.size(); ++i) {
            const CameraPose& pose = result_.photographs[i].pose.pose;
            const Eigen::Vector3d camera = pose.position + up,
                                  light = camera + pose.rotation.transpose() * flash;
            View& view = result_.views.views.emplace_back();
            view.image = fmt::format("{:02}.{}", i, options_.response == Response::Linear ? "exr" : "png");
            if (!(light.z() > 0))
                throw SceneError({files_[i]},
                                 fmt::format("by --flash the light is {:.3g} cm below the sample; expected "
                                             "the place of the light from the camera",
                                             -light.z()));
            view.camera = {camera.x(), camera.y(), camera.z()};
            view.light = {light.x(), light.y(), light.z()};
        }
    }

    void WarnOfPixels() {
        std::vector<CameraPose> poses;
        for (const CapturedPhotograph& photograph : result_.photographs) {
            poses.push_back(photograph.pose.pose);
            if (photograph.clippedShare > kManyClipped)
                result_.warnings.push_back(
                    fmt::format("{}: {:.0f} % of the sample is overexposed; a shorter exposure "
                                "would help",
                                photograph.file, 100 * photograph.clippedShare));
            if (photograph.outsideShare > 0)
                result_.warnings.push_back(
                    fmt::format("{}: {:.1f} % of the sample is outside of the photograph", photograph.file,
                                100 * photograph.outsideShare));
        }
        result_.pixelsAcross =
            PixelsAcross(result_.calibration.intrinsics, poses, SquareSize(), options_.depth);
        if (options_.resolution > 1.5 * result_.pixelsAcross)
            result_.warnings.push_back(
                fmt::format("the photographs have about {:.0f} pixels along the edge of the "
                            "sample: the {} asked for show no more",
                            result_.pixelsAcross, options_.resolution));
    }

    const std::vector<std::string>& files_;
    const CaptureOptions& options_;
    std::vector<FileFacts> facts_;
    CapturedPhotographs result_;
};

}  // namespace

CapturedPhotographs CapturePhotographs(const std::vector<std::string>& files, const CaptureOptions& options) {
    return Capture(files, options).Run();
}

void WriteRectified(const CapturedPhotographs& captured, const std::string& folder) {
    const ColorEncoding encoding = EncodingOf(captured.views.response), srgb = EncodingOf(Response::SRGB);
    for (size_t i = 0; i < captured.photographs.size(); ++i) {
        Image image = captured.photographs[i].rectified;
        // Files of bytes are written with the codes of sRGB: these values have the codes of the response.
        if (captured.views.response != Response::Linear)
            for (float& v : image.Pixels()) v = srgb.ToLinear(encoding.FromLinear(v));
        WriteImage(image, (std::filesystem::path(folder) / captured.views.views[i].image).string());
    }
}

}  // namespace lacquer::capture
