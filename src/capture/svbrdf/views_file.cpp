#include "capture/svbrdf/views_file.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <utility>

#include "capture/svbrdf/svbrdf_model.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/json_reader.h"
#include "pbrt/core/output_file.h"
#include "pbrt/core/parallel.h"
#include "pbrt/image/image.h"

namespace lacquer::capture {
namespace {

const std::vector<std::string> kKeys = {"unit", "size", "response", "lightPower", "views"};
const std::vector<std::string> kViewKeys = {"image", "camera", "light", "use"};
const std::vector<std::string> kPublishedKeys = {"im_size", "camera_pos", "light_pos", "light_pow", "idx"};
const std::vector<std::pair<std::string, Response>> kResponses = {
    {"gamma2.2", Response::Gamma22}, {"srgb", Response::SRGB}, {"linear", Response::Linear}};
const std::vector<std::pair<std::string, bool>> kUses = {{"fit", false}, {"test", true}};

constexpr double kMaxLength = 1e5;  ///< [cm]
constexpr size_t kMaxViews = 1000;
constexpr JsonReader::Length kPoint{3, "x, y and z [cm]"}, kColor{3, "red, green and blue"};

class ViewsReader : JsonReader {
  public:
    ViewsReader(std::string_view text, const std::string& path)
        : JsonReader(text, path, "the views of a sample") {}

    ViewSet Read() {
        // Who mixes both forms meets keys that are unknown in one of them.
        if (!Has("/views") && (Has("/im_size") || Has("/camera_pos")))
            ReadPublished();
        else
            ReadOurs();
        for (const View& view : set_.views)
            if (!view.isTest) return std::move(set_);
        Fail("/views", "all views are for tests; expected one at least to be fitted");
    }

  private:
    void ReadOurs() {
        CheckKeys("", kKeys);
        if (Has("/unit")) Require("/unit", "cm", ", the only unit");
        set_.size = Positive("/size");
        if (Has("/response")) set_.response = Choice("/response", kResponses);
        ReadPower("/lightPower");
        const size_t count = NumViews("/views", "a list of views");
        for (size_t i = 0; i < count; ++i) {
            const std::string at = fmt::format("/views/{}", i);
            CheckKeys(at, kViewKeys);
            View view;
            view.image = Text(at + "/image");
            view.camera = PointAbove(at + "/camera");
            view.light = Has(at + "/light") ? PointAbove(at + "/light") : view.camera;
            view.isTest = Has(at + "/use") && Choice(at + "/use", kUses);
            set_.views.push_back(std::move(view));
        }
    }

    void ReadPublished() {
        CheckKeys("", kPublishedKeys);
        set_.size = Positive("/im_size");
        ReadPower("/light_pow");
        const size_t count = NumViews("/camera_pos", "a list of places");
        const bool hasLights = Has("/light_pos");
        if (hasLights && NumViews("/light_pos", "a list of places") != count)
            Fail("/light_pos", fmt::format("there are {} lights and {} cameras; expected one for each",
                                           At("/light_pos").size(), count));
        for (const size_t i : Indices(count)) {
            View view;
            view.image = fmt::format("{:02}.png", i);
            view.camera = PointAbove(fmt::format("/camera_pos/{}", i));
            view.light = hasLights ? PointAbove(fmt::format("/light_pos/{}", i)) : view.camera;
            set_.views.push_back(std::move(view));
        }
    }

    std::vector<size_t> Indices(size_t count) const {
        std::vector<size_t> indices;
        if (!Has("/idx")) {
            for (size_t i = 0; i < count; ++i) indices.push_back(i);
            return indices;
        }
        for (const double number : Numbers("/idx", {}, 0, double(count) - 1)) {
            const std::string at = fmt::format("/idx/{}", indices.size());
            if (number != std::floor(number))
                Fail(at, fmt::format("found {}; expected a whole number", KindOf(At(at))));
            for (const size_t other : indices)
                if (other == size_t(number)) Fail(at, fmt::format("view {} is listed twice", other));
            indices.push_back(size_t(number));
        }
        if (indices.empty()) Fail("/idx", "the list is empty; expected the views that count");
        return indices;
    }

    double Positive(const std::string& at) const {
        const Json& value = At(at);
        const double number = value.is_number() ? value.get<double>() : 0;
        if (!(number > 0 && number <= kMaxLength))
            Fail(at, fmt::format("found {}; expected a length above 0, up to {:g} cm", KindOf(value),
                                 kMaxLength));
        return number;
    }

    void ReadPower(const std::string& at) {
        if (!Has(at)) return;
        const bool isOne = At(at).is_number();
        const std::vector<double> power = isOne ? std::vector<double>(3, Number(at, 0, kMaxLightPower))
                                                : Numbers(at, kColor, 0, kMaxLightPower);
        for (size_t c = 0; c < 3; ++c) {
            if (!(power[c] > 0)) Fail(isOne ? at : fmt::format("{}/{}", at, c), "found 0; expected a light");
            set_.lightPower[c] = power[c];
        }
    }

    size_t NumViews(const std::string& at, const char* what) const {
        const Json& list = At(at);
        if (!list.is_array() || list.empty())
            Fail(at, fmt::format("found {}; expected {}", KindOf(list), what));
        if (list.size() > kMaxViews)
            Fail(at, fmt::format("there are {} views; expected at most {}", list.size(), kMaxViews));
        return list.size();
    }

    Point PointAbove(const std::string& at) const {
        const std::vector<double> p = Numbers(at, kPoint, -kMaxLength, kMaxLength);
        if (!(p[2] > 0))
            Fail(at + "/2", fmt::format("z is {}; expected a place above the sample, which lies at 0", p[2]));
        return {p[0], p[1], p[2]};
    }

    std::string Text(const std::string& at) const {
        const Json& value = At(at);
        if (!value.is_string() || value.get_ref<const std::string&>().empty())
            Fail(at, fmt::format("found {}; expected the name of a file", KindOf(value)));
        return value.get<std::string>();
    }

    template <class T>
    T Choice(const std::string& at, const std::vector<std::pair<std::string, T>>& choices) const {
        const Json& value = At(at);
        std::vector<std::string> names;
        for (const auto& [name, meaning] : choices) {
            if (value == name) return meaning;
            names.push_back(name);
        }
        Fail(at, fmt::format("found {}; expected one of {}{}", KindOf(value), fmt::join(names, ", "),
                             value.is_string() ? DidYouMean(value.get<std::string>(), names) : ""));
    }

    ViewSet set_;
};

void CheckPhotograph(const Image& image, int size, const FileLoc& place) {
    const Int2 resolution = image.Resolution();
    if (resolution.x != resolution.y)
        throw SceneError(place, fmt::format("the image has {} x {} pixels; expected a square", resolution.x,
                                            resolution.y));
    if (resolution.x < size)
        throw SceneError(place, fmt::format("the image has {0} x {0} pixels; expected {1} x {1} at least",
                                            resolution.x, size));
    const int alpha = image.FindChannel("A");
    if (!image.HasRGB() && !(image.NumChannels() - (alpha >= 0 ? 1 : 0) == 1))
        throw SceneError(place, "expected the channels R, G and B, or one alone");
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x)
            for (int c = 0; c < (image.HasRGB() ? 3 : 1); ++c)
                if (const float v = image.Get({x, y}, c); !(v >= 0 && std::isfinite(v)))
                    throw SceneError(place,
                                     fmt::format("pixel {},{} has the value {} in channel {}; expected a "
                                                 "finite number, at least 0",
                                                 x, y, v, image.Channels()[size_t(c)]));
}

/// Shares of the pixels [first, ...) under one of `to` cells over `from` pixels.
struct Cover {
    int first;
    std::vector<double> shares;
};
Cover CoverOf(int cell, int from, int to) {
    const double begin = double(cell) * from / to, end = double(cell + 1) * from / to;
    Cover cover{int(begin), {}};
    for (int i = cover.first; i < from && i < end; ++i)
        cover.shares.push_back((std::min(end, i + 1.) - std::max(begin, double(i))) / (end - begin));
    return cover;
}

}  // namespace

ViewSet ParseViews(std::string_view text, const std::string& path) { return ViewsReader(text, path).Read(); }

ViewSet ReadViews(const std::string& path) {
    constexpr size_t kMaxBytes = size_t(16) << 20;
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = kMaxBytes, .advice = " of views"});
    return ParseViews(bytes.View(), path);
}

void WriteViews(const ViewSet& views, const std::string& path) {
    nlohmann::ordered_json root;
    root["unit"] = "cm";
    root["size"] = views.size;
    for (const auto& [name, response] : kResponses)
        if (response == views.response) root["response"] = name;
    root["lightPower"] = views.lightPower;
    root["views"] = nlohmann::ordered_json::array();
    for (const View& view : views.views)
        root["views"].push_back({{"image", view.image},
                                 {"camera", view.camera},
                                 {"light", view.light},
                                 {"use", view.isTest ? "test" : "fit"}});
    OutputFile file(path);
    file.Write(root.dump(1) + "\n");
    file.Finish();
}

RectifiedImage ReadRectifiedImage(const std::string& path, Response response, int size) {
    const FileLoc place{path};
    const ColorEncoding encoding = EncodingOf(response);
    const Image image = ReadImage(path, encoding, {});  // whose messages name the file
    CheckPhotograph(image, size, place);
    // Formats other than PNG were decoded as sRGB; their codes are what the response has to decode.
    const bool isRecoded = image.format == PixelFormat::Byte && image.encoding != encoding;
    std::vector<Cover> covers;
    for (int i = 0; i < size; ++i) covers.push_back(CoverOf(i, image.Resolution().x, size));

    RectifiedImage result(size);
    ParallelFor(size, [&](int64_t row) {
        const Cover& rows = covers[size_t(row)];
        for (int column = 0; column < size; ++column)
            for (int c = 0; c < 3; ++c) {
                const Cover& columns = covers[size_t(column)];
                double sum = 0;
                for (size_t i = 0; i < rows.shares.size(); ++i)
                    for (size_t j = 0; j < columns.shares.size(); ++j) {
                        float v =
                            image.Get({columns.first + int(j), rows.first + int(i)}, image.HasRGB() ? c : 0);
                        if (isRecoded) v = encoding.ToLinear(image.encoding.FromLinear(v));
                        sum += rows.shares[i] * columns.shares[j] * double(v);
                    }
                result.Channel(size_t(c))[size_t(row) * size_t(size) + size_t(column)] =
                    std::pow(ClampTo(sum, 0, 1), 1 / kModelGamma);
            }
    });
    return result;
}

std::vector<RectifiedImage> ReadViewImages(const ViewSet& views, const std::string& directory, int size) {
    std::vector<RectifiedImage> images;
    for (const View& view : views.views) {
        const std::filesystem::path path = std::filesystem::path(directory) / view.image;
        images.push_back(ReadRectifiedImage(path.string(), views.response, size));
    }
    return images;
}

}  // namespace lacquer::capture
