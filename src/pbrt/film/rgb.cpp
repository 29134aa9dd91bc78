// Film "rgb": linear RGB in the colour space of the scene.
//
//   "integer xresolution", "integer yresolution"  1280, 720    of the full image [pixels]
//   "string filename"                             lacquer.exr  output; the extension chooses the format
//   "integer pixelbounds" [4]                     all          x0 x1 y0 y1: the part that is rendered; the
//                                                              ends are not included
//   "float cropwindow" [4]                        0 1 0 1      the same as fractions of the image; takes
//                                                              precedence
//   "float diagonal"                              35           of the film [mm]; for camera "realistic"
//   "float maxcomponentvalue"                     infinity     samples are scaled down to this sensor
//                                                              response
//   "bool savefp16"                               false        16-bit floats in the file instead of 32-bit
//                                                              ones
//   "string sensor"                               cie1931      the ideal observer, or a camera: see sensor.h
//   "float iso"                                   100          sensitivity: the image is scaled by shutter
//                                                              time x iso / 100
//   "float whitebalance"                          0            colour temperature that becomes white, 500 to
//                                                              25000 [K]; 0: the sensor's own
#include "pbrt/film/rgb.h"

#include <fmt/format.h>

#include "pbrt/film/render_state.h"
#include "pbrt/image/image.h"

namespace lacquer {
namespace {

// 72 bytes a pixel: one film stays at or below 2.25 GiB. 7680 x 4320 fits; more is rendered in crop windows.
constexpr int64_t kMaxPixels = int64_t(1) << 25;

Bounds2i CropBounds(const std::array<float, 4>& window, Int2 resolution) {
    const auto edge = [](float fraction, int size) {
        return int(std::ceil(std::clamp(fraction, 0.f, 1.f) * float(size)));
    };
    return {{edge(std::min(window[0], window[1]), resolution.x),
             edge(std::min(window[2], window[3]), resolution.y)},
            {edge(std::max(window[0], window[1]), resolution.x),
             edge(std::max(window[2], window[3]), resolution.y)}};
}

/// The nearest float: the output matrix can take a response out of a float's range.
float ToFloat(double x) {
    constexpr double kLargest = double(std::numeric_limits<float>::max());
    return float(std::clamp(x, -kLargest, kLargest));
}

}  // namespace

RGBFilm::RGBFilm(FilmArgs args)
    : sensor_(args.params, args.shutterTime, args.params.ColorSpace()),
      maxComponentValue_(args.params.GetFloat("maxcomponentvalue", Infinity)) {
    const Params& params = args.params;
    filter_ = std::move(args.filter);
    colorSpace_ = &params.ColorSpace();
    filename_ = params.GetString("filename", "lacquer.exr");
    if (!args.overrides.filename.empty()) filename_ = args.overrides.filename;
    savesHalf_ = params.GetBool("savefp16", false);
    diagonal_ = params.GetFloatInRange("diagonal", 35, 1e-3f, 1e6f);
    if (std::isnan(maxComponentValue_) || maxComponentValue_ <= 0)
        params.Fail("maxcomponentvalue",
                    fmt::format("maxcomponentvalue is {}; it must be positive", maxComponentValue_));
    ReadResolution(params, args.overrides);
    ReadBounds(params, args.overrides);
    counts_.resize(size_t(pixelBounds_.Area()));
    sums_ = ExactSums(kNumSums * counts_.size());
    if (args.overrides.keepsHalves) halves_ = ExactSums(kNumSums * counts_.size());
}

void RGBFilm::ReadResolution(const Params& params, const FilmOverrides& overrides) {
    resolution_ = {params.GetIntInRange("xresolution", 1280, 1, kMaxFilmSide),
                   params.GetIntInRange("yresolution", 720, 1, kMaxFilmSide)};
    if (overrides.resolution) resolution_ = *overrides.resolution;
    if (overrides.quick) resolution_ = glm::max(resolution_ / 4, 1);
}

void RGBFilm::ReadBounds(const Params& params, const FilmOverrides& overrides) {
    const Bounds2i full{Int2(0), resolution_};
    pixelBounds_ = full;
    const std::vector<int> bounds = params.GetInts("pixelbounds");
    const std::vector<float> crop = params.GetFloats("cropwindow");
    if (!bounds.empty()) {
        if (bounds.size() != 4)
            params.Fail(
                "pixelbounds",
                fmt::format("pixelbounds has {} values; four are expected: x0 x1 y0 y1", bounds.size()));
        pixelBounds_ = Bounds2i{{bounds[0], bounds[2]}, {bounds[1], bounds[3]}}.Intersect(full);
    }
    if (!crop.empty()) {
        if (crop.size() != 4)
            params.Fail("cropwindow",
                        fmt::format("cropwindow has {} values; four are expected: x0 x1 y0 y1", crop.size()));
        pixelBounds_ = CropBounds({crop[0], crop[1], crop[2], crop[3]}, resolution_);
    }
    if (overrides.cropWindow) pixelBounds_ = CropBounds(*overrides.cropWindow, resolution_);
    if (overrides.pixelBounds) pixelBounds_ = overrides.pixelBounds->Intersect(full);
    if (pixelBounds_.IsEmpty() && (overrides.cropWindow || overrides.pixelBounds))
        throw OverrideError(fmt::format(
            "{} no pixel of the {} x {} image to render",
            overrides.pixelBounds ? "the given pixel bounds leave" : "the given crop window leaves",
            resolution_.x, resolution_.y));
    const char* part = crop.empty() ? "pixelbounds" : "cropwindow";
    if (pixelBounds_.IsEmpty())
        params.Fail(part, fmt::format("\"{}\" leaves no pixel of the {} x {} image to render", part,
                                      resolution_.x, resolution_.y));
    if (pixelBounds_.Area() > kMaxPixels)
        throw SceneError(
            params.LocOf("xresolution"),
            fmt::format(
                "{} x {} pixels are more than the {} that one film may hold; render it in crop windows",
                pixelBounds_.Width(), pixelBounds_.Height(), kMaxPixels));
}

std::optional<Vec3> RGBFilm::Response(SampledSpectrum L, const SampledWavelengths& lambda) const {
    if (!L.IsValid()) return std::nullopt;
    const Vec3 response = sensor_.Response(L, lambda);
    // Finite radiance can still overflow in the sensor.
    if (!IsFinite(response)) return std::nullopt;
    return response * LimitingScale(response);
}

float RGBFilm::LimitingScale(Vec3 response) const {
    const float largest = MaxComponent(response);
    return largest > maxComponentValue_ ? maxComponentValue_ / largest : 1;
}

float RGBFilm::LimitOf(SampledSpectrum L, const SampledWavelengths& lambda) const {
    return maxComponentValue_ < Infinity ? LimitingScale(sensor_.Response(L, lambda)) : 1;
}

void RGBFilm::RequireEXR(const char* film, const Params& params, const FilmOverrides& overrides) const {
    if (ExtensionOf(filename_) == "exr") return;
    const std::string problem = fmt::format(
        "the film \"{}\" needs an EXR file for its channels; \"{}\" holds colours only", film, filename_);
    if (!overrides.filename.empty()) throw OverrideError(problem);
    params.Fail("filename", problem);
}

bool RGBFilm::AddSample(Int2 p, SampledSpectrum L, const SampledWavelengths& lambda, float weight) {
    const size_t pixel = Index(p);
    const std::optional<Vec3> response = Response(L, lambda);
    AddTo(&sums_, pixel, response, double(weight));
    if (halves_.Size() > 0 && Halves().IsFirst(counts_[pixel], pixel))
        AddTo(&halves_, pixel, response, double(weight));
    ++counts_[pixel];
    return response.has_value();
}

void RGBFilm::AddPasses(Int2 p, SampledSpectrum L, std::span<const SampledSpectrum> passes,
                        const SampledWavelengths& lambda, float weight) {
    const double scaled = double(weight) * double(LimitOf(L, lambda));
    const size_t pixel = Index(p);
    for (size_t i = 0; i < passes.size(); ++i)
        if (passes[i]) passes_.Add(pixel, i, sensor_.Response(passes[i], lambda), scaled);
}

std::unique_ptr<Image> RGBFilm::AppendPasses(const Image& image) const {
    std::vector<std::string> channels;
    for (const std::string& layer : passes_.Layers())
        for (const char* component : {".R", ".G", ".B"}) channels.push_back(layer + component);
    auto extended = std::make_unique<Image>(image.WithRoomFor(channels));
    const glm::dmat3 rgbFromSensor(sensor_.RGBFromSensor());
    const size_t before = size_t(image.NumChannels());
    float* out = extended->Pixels().data();
    for (size_t i = 0; i < counts_.size(); ++i) {
        out += before;
        const double weight = sums_[kNumSums * i + 3];
        for (size_t pass = 0; pass < passes_.NumPasses(); ++pass) {
            glm::dvec3 rgb = rgbFromSensor * passes_.Sum(i, pass);
            if (weight != 0) rgb /= weight;
            for (int c = 0; c < 3; ++c) *out++ = ToFloat(rgb[c]);
        }
    }
    return extended;
}

bool RGBFilm::AddSplat(Point2 p, SampledSpectrum L, const SampledWavelengths& lambda) {
    const std::optional<Vec3> response = Response(L, lambda);
    if (!response || !std::isfinite(p.x + p.y)) return false;
    splats_.Add(p, *response, *filter_);
    return true;
}

double RGBFilm::SplatScale() const {
    double paths = 0;
    for (const int count : counts_) paths += count;
    const double area = double(resolution_.x) * double(resolution_.y);
    return paths > 0 ? area / (paths * double(filter_->Integral())) : 0;
}

void RGBFilm::AppendState(std::vector<StateArray>* arrays) {
    arrays->push_back({"counts", &counts_});
    arrays->push_back({"colors", &sums_});
    if (halves_.Size() > 0) arrays->push_back({"half colors", &halves_});
    if (passes_.NumPasses() > 0) arrays->push_back({"passes", &passes_.Sums()});
    if (splats_.IsPrepared()) arrays->push_back({"splats", &splats_.Gathered()});
}

glm::dvec3 RGBFilm::MeanOf(const ExactSums& sums, size_t pixel) {
    const size_t first = kNumSums * pixel;
    const glm::dvec3 response(sums[first], sums[first + 1], sums[first + 2]);
    const double weight = sums[first + 3];
    return weight != 0 ? response / weight : response;
}

std::unique_ptr<Image> RGBFilm::Develop() const {
    const bool hasHalves = halves_.Size() > 0;
    std::vector<std::string> channels{"R", "G", "B"};
    if (hasHalves) channels.insert(channels.end(), {"Half.R", "Half.G", "Half.B"});
    auto image = std::make_unique<Image>(Int2(pixelBounds_.Width(), pixelBounds_.Height()), channels);
    image->dataWindow = pixelBounds_;
    image->fullResolution = resolution_;
    image->SetColorSpace(colorSpace_);
    const glm::dmat3 rgbFromSensor(sensor_.RGBFromSensor());
    const double splatScale = splats_.IsPrepared() ? SplatScale() : 0;
    float* out = image->Pixels().data();
    const auto write = [&](glm::dvec3 response) {
        const glm::dvec3 rgb = rgbFromSensor * response;
        for (int c = 0; c < 3; ++c) *out++ = ToFloat(rgb[c]);
    };
    for (size_t i = 0; i < counts_.size(); ++i) {
        glm::dvec3 response = MeanOf(sums_, i);
        if (splatScale != 0) response += splatScale * splats_.Sum(i);
        write(response);
        if (hasHalves) write(MeanOf(halves_, i));
    }
    return image;
}

namespace {

std::unique_ptr<Film> CreateRGBFilm(FilmArgs args) { return std::make_unique<RGBFilm>(std::move(args)); }

}  // namespace

LACQUER_REGISTER(FilmKind, "rgb", CreateRGBFilm);

}  // namespace lacquer
