#include "estimate/photo/photograph_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimate/photo/tone.h"

namespace lacquer::estimate {

namespace {

/// Diagonal of the frame that focal lengths "as of 35 mm film" speak of [mm].
const double kFilmDiagonal = std::hypot(36., 24.);

/// What is the largest value, but for dither and noise of compression; and what is the smallest.
constexpr float kClippedCode = 254.5F / 255, kBlackCode = 0.5F / 255;

/// One reading: a file, checked and cut step by step.
class Reading {
  public:
    Reading(const std::string& path, const PhotographReading& settings)
        : settings_(settings), place_{path}, image_(ReadImage(path, settings.tone, place_)) {}

    PhotographFile Read() {
        result_.fileResolution = image_.Resolution();
        CheckChannels();
        CheckValues();
        ChooseCrop();
        MeasureFieldOfView();
        WarnOfLosses();
        TakeColors();
        CheckExposure();
        Reduce();
        return std::move(result_);
    }

  private:
    [[noreturn]] void Refuse(const std::string& message) const { throw SceneError(place_, message); }

    void CheckChannels() {
        const bool isLuminance = image_.NumChannels() == 1 || image_.Channels()[0] == "Y";
        if (!image_.HasRGB() && !isLuminance) {
            std::string names;
            for (const std::string& name : image_.Channels())
                names += (names.empty() ? "" : ", ") + Excerpt(name);
            Refuse(fmt::format("the image has the channels {}; expected R, G and B, or one channel", names));
        }
        const int alpha = image_.FindChannel("A");
        const Int2 size = image_.Resolution();
        for (int y = 0; alpha >= 0 && y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                if (!(image_.Get({x, y}, alpha) >= 1))
                    Refuse(fmt::format("pixel {},{} is transparent; expected an opaque photograph", x, y));
    }

    int NumColors() const { return image_.HasRGB() ? 3 : 1; }

    void CheckValues() const {
        const Int2 size = image_.Resolution();
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                for (int c = 0; c < NumColors(); ++c)
                    if (const float v = image_.Get({x, y}, c); !(v >= 0 && std::isfinite(v)))
                        Refuse(
                            fmt::format("pixel {},{} has the value {} in channel {}; expected a finite "
                                        "number, at least 0",
                                        x, y, v, image_.Channels()[size_t(c)]));
    }

    void ChooseCrop() {
        const Int2 size = image_.Resolution();
        const int side = std::min(size.x, size.y);
        result_.crop = settings_.crop.value_or(
            Bounds2i{{(size.x - side) / 2, (size.y - side) / 2}, {(size.x + side) / 2, (size.y + side) / 2}});
        const Int2 crop{result_.crop.Width(), result_.crop.Height()};
        if (result_.crop.Intersect({{0, 0}, size}) != result_.crop)
            Refuse(fmt::format("the crop leaves the image of {} x {} pixels", size.x, size.y));
        if (crop.x != crop.y)
            Refuse(fmt::format("the crop has {} x {} pixels; expected a square", crop.x, crop.y));
        if (crop.x < kMinPhotographSide)
            Refuse(fmt::format("the photograph has {} x {} pixels; expected at least {} x {}", crop.x, crop.y,
                               kMinPhotographSide, kMinPhotographSide));
        if (!settings_.crop && size.x != size.y)
            result_.notes.emplace_back(
                fmt::format("of {} x {} pixels the square at the centre is taken, {} x {}", size.x, size.y,
                            crop.x, crop.y));
    }

    /// Of a lens without distortion, whose axis is the centre of the frame.
    void MeasureFieldOfView() {
        const auto it = image_.metadata.find("Exif:FocalLengthIn35mmFilm");
        if (it == image_.metadata.end()) return;
        const auto* asInt = std::get_if<int>(&it->second);
        const auto* asFloat = std::get_if<float>(&it->second);
        const double focalLength = asInt ? *asInt : asFloat ? double(*asFloat) : 0;
        if (!(focalLength > 0)) return;
        const Int2 size = image_.Resolution();
        const double pixel = kFilmDiagonal / std::hypot(size.x, size.y);
        result_.fieldOfView =
            2 * std::atan(0.5 * result_.crop.Width() * pixel / focalLength) * 180 / std::numbers::pi;
    }

    /// Relief is found in details that such files leave out, without a sign.
    void WarnOfLosses() {
        const std::string extension = ExtensionOf(place_.file);
        if (extension == "jpg" || extension == "jpeg")
            result_.warnings.emplace_back(
                "JPEG leaves out fine detail, which relief is estimated from: PNG or TIFF say more, and what "
                "is found may be wrong without a sign");
    }

    /// The crop as an image of three channels that hold what the tone curve decodes to, in [0,1].
    void TakeColors() {
        const Bounds2i crop = result_.crop;
        colors_ = Image({crop.Width(), crop.Height()}, {"R", "G", "B"});
        // Formats other than PNG were decoded as sRGB; their codes are what the tone curve has to decode.
        const bool isRecoded = image_.format == PixelFormat::Byte && image_.encoding != settings_.tone;
        bool isGray = true;
        for (int y = crop.min.y; y < crop.max.y; ++y)
            for (int x = crop.min.x; x < crop.max.x; ++x) {
                const Int2 p{x - crop.min.x, y - crop.min.y};
                for (int c = 0; c < 3; ++c) {
                    float value = image_.Get({x, y}, NumColors() == 3 ? c : 0);
                    if (isRecoded) value = settings_.tone.ToLinear(image_.encoding.FromLinear(value));
                    colors_.Set(p, c, std::min(value, 1.F));
                }
                isGray = isGray && IsGray(p);
            }
        if (isGray)
            result_.warnings.emplace_back(
                "the photograph is grey: what it says about colours is what the prior says");
    }

    /// But for what dither and compression add to codes.
    bool IsGray(Int2 p) const {
        constexpr float kTolerance = 2.5F / 255;
        float codes[3];
        for (int c = 0; c < 3; ++c) codes[c] = settings_.tone.FromLinear(colors_.Get(p, c));
        return std::abs(codes[0] - codes[1]) < kTolerance && std::abs(codes[1] - codes[2]) < kTolerance;
    }

    void CheckExposure() {
        const float clipped = settings_.tone.ToLinear(kClippedCode),
                    black = settings_.tone.ToLinear(kBlackCode);
        const Int2 size = colors_.Resolution();
        int64_t numClipped = 0, numBlack = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                float largest = 0;
                for (int c = 0; c < 3; ++c) largest = std::max(largest, colors_.Get({x, y}, c));
                numClipped += largest >= clipped;
                numBlack += largest <= black;
            }
        const double count = double(size.x) * size.y;
        result_.clipped = double(numClipped) / count;
        result_.black = double(numBlack) / count;
        if (result_.clipped > kTooManyClipped)
            Refuse(fmt::format(
                "{:.0f} % of the pixels are clipped; expected at most {:.0f} %: a shorter exposure",
                100 * result_.clipped, 100 * kTooManyClipped));
        if (result_.clipped > kManyClipped)
            result_.warnings.emplace_back(fmt::format(
                "{:.0f} % of the pixels are clipped: the highlight, which tells roughness, is partly lost; a "
                "shorter exposure would help",
                100 * result_.clipped));
        if (result_.black == 1) Refuse("every pixel is black; expected a photograph by flash");
        if (result_.black > kTooManyClipped)
            result_.warnings.emplace_back(fmt::format(
                "{:.0f} % of the pixels are black, and tell nothing; a longer exposure would help",
                100 * result_.black));
    }

    void Reduce() {
        const int side = colors_.Resolution().x, size = std::min(settings_.resolution, side / 16 * 16);
        if (size < settings_.resolution)
            result_.notes.emplace_back(fmt::format(
                "the photograph has {0} x {0} pixels, and {1} x {1} were asked for: {2} x {2} are looked at",
                side, settings_.resolution, size));
        // The nearest whole number of the file's pixels, as far as simulations follow.
        const int wanted = std::max(1, (2 * side + size) / (2 * size));
        result_.averaging = std::clamp(settings_.simulatedResolution / size, 1, wanted);
        if (result_.averaging < wanted)
            result_.warnings.emplace_back(fmt::format(
                "the photograph has {0} x {0} pixels, and is simulated with {1} x {1}: relief finer "
                "than that is not in the simulations; --simulated-resolution allows more",
                side, size * result_.averaging));
        const int fineSize = size * result_.averaging;
        const Image reduced = fineSize == side ? colors_ : Resize(colors_, {fineSize, fineSize});
        PlanarImage fine(fineSize);
        for (int c = 0; c < 3; ++c) {
            const std::span<double> channel = fine.Channel(size_t(c));
            for (int y = 0; y < fineSize; ++y)
                for (int x = 0; x < fineSize; ++x)
                    channel[size_t(y) * size_t(fineSize) + size_t(x)] = double(reduced.Get({x, y}, c));
        }
        AverageClamped(fine, result_.averaging, &result_.linear);
    }

    const PhotographReading& settings_;
    FileLoc place_;
    Image image_, colors_;
    PhotographFile result_;
};

}  // namespace

PhotographFile ReadPhotograph(const std::string& path, const PhotographReading& reading) {
    return Reading(path, reading).Read();
}

}  // namespace lacquer::estimate
