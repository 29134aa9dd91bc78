#include "pbrt/image/texture_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace lacquer {

namespace {

constexpr int kEdge = PyramidSource::kEdge;

int IndexOf(const std::vector<std::string>& channels, const char* name) {
    const auto it = std::find(channels.begin(), channels.end(), name);
    return it == channels.end() ? -1 : int(it - channels.begin());
}

/// Which of the stored outermost rows or columns `i` of `count` is; all are stored where there are few.
int EdgeIndex(int i, int count) { return i < kEdge ? i : std::min(count, 2 * kEdge) - (count - i); }
bool IsAtEdge(int i, int count) { return i < kEdge || i >= count - kEdge; }

}  // namespace

TextureSurvey::TextureSurvey(std::vector<std::string> channels)
    : channels_(std::move(channels)),
      r_(IndexOf(channels_, "R")),
      g_(IndexOf(channels_, "G")),
      b_(IndexOf(channels_, "B")),
      a_(IndexOf(channels_, "A")),
      lowest_(std::numeric_limits<float>::infinity()) {}

void TextureSurvey::AddValues(std::span<const float> values) {
    // Side by side: one after another, each would wait for the comparison of the one before it.
    constexpr size_t kLanes = 8;
    std::array<float, kLanes> lowest;
    lowest.fill(lowest_);
    std::array<int, kLanes> isFinite;
    isFinite.fill(1);
    const auto add = [&](size_t lane, float value) {
        isFinite[lane] &= int(std::abs(value) <= std::numeric_limits<float>::max());
        lowest[lane] = value < lowest[lane] ? value : lowest[lane];
    };
    size_t i = 0;
    for (; i + kLanes <= values.size(); i += kLanes)
        for (size_t lane = 0; lane < kLanes; ++lane) add(lane, values[i + lane]);
    for (; i < values.size(); ++i) add(0, values[i]);
    lowest_ = *std::min_element(lowest.begin(), lowest.end());
    isFinite_ = isFinite_ && *std::min_element(isFinite.begin(), isFinite.end()) == 1;
}

void TextureSurvey::AddPixels(const float* pixels, size_t count) {
    const size_t stride = channels_.size();
    AddValues({pixels, count * stride});
    if (r_ < 0 || g_ < 0 || b_ < 0) return;
    for (const float* p = pixels; isGrey_ && p != pixels + count * stride; p += stride)
        isGrey_ = p[r_] == p[g_] && p[r_] == p[b_];
    if (a_ < 0) return;
    for (const float* p = pixels; isOpaque_ && p != pixels + count * stride; p += stride)
        isOpaque_ = p[a_] == 1;
}

std::vector<int> TextureSurvey::UsedChannels(const std::string& path, const FileLoc& loc) const {
    if (channels_.size() > 1 && (r_ < 0 || g_ < 0 || b_ < 0))
        throw SceneError(loc, fmt::format("{}: a texture needs one channel, or R, G and B; this image has {}",
                                          path, fmt::join(channels_, ", ")));
    if (!isFinite_)
        throw SceneError(
            loc, fmt::format("{}: the image has pixels that are not finite numbers; a texture needs numbers",
                             path));
    if (channels_.size() == 1) return {0};
    if (a_ >= 0 && !isOpaque_) return {r_, g_, b_, a_};
    return isGrey_ ? std::vector<int>{r_} : std::vector<int>{r_, g_, b_};
}

FileSource::FileSource(const std::string& path, ColorEncoding encoding, const FileLoc& loc,
                       std::function<void()> advance)
    : path_(path),
      encoding_(encoding),
      loc_(loc),
      advance_(std::move(advance)),
      file_(std::make_unique<ImageFile>(path, encoding, loc)),
      header_(file_->Header()) {
    file_->CheckPixels();
    TextureSurvey survey(header_.channels);
    const size_t stride = header_.channels.size();
    const Int2 edges = glm::min(header_.resolution, Int2(2 * kEdge));
    edgeRows_.resize(size_t(edges.y) * size_t(header_.resolution.x) * stride);
    edgeColumns_.resize(size_t(edges.x) * size_t(header_.resolution.y) * stride);
    for (int y = 0; y < header_.resolution.y; ++y) {
        if (y >= band_.end) ReadBand(y);
        const float* const row =
            &band_.values[size_t(y - band_.begin) * size_t(header_.resolution.x) * stride];
        survey.AddPixels(row, size_t(header_.resolution.x));
        KeepEdges(y, row);
        advance_();
    }
    channels_ = survey.UsedChannels(path, loc);
    lowest_ = survey.Lowest();
    row_.resize(size_t(header_.resolution.x) * channels_.size());
    // Readers of compressed files only go forward.
    file_ = std::make_unique<ImageFile>(path, encoding, loc, true);
    band_ = {};
    const ImageHeader& again = file_->Header();
    if (again.resolution != header_.resolution || again.channels != header_.channels ||
        again.format != header_.format)
        throw SceneError(loc, fmt::format("{}: the image changed while it was read", path));
}

void FileSource::ReadBand(int begin) {
    const int end = std::min(header_.resolution.y, begin + file_->RowsAtOnce());
    band_ = {begin, end, std::move(band_.values)};
    band_.values.resize(size_t(end - begin) * size_t(header_.resolution.x) * header_.channels.size());
    file_->ReadRows(begin, end, band_.values.data());
}

void FileSource::KeepEdges(int y, const float* row) {
    const size_t stride = header_.channels.size();
    const Int2 resolution = header_.resolution;
    const size_t rowValues = size_t(resolution.x) * stride;
    if (IsAtEdge(y, resolution.y))
        std::copy_n(row, rowValues, &edgeRows_[size_t(EdgeIndex(y, resolution.y)) * rowValues]);
    const size_t columns = size_t(std::min(resolution.x, 2 * kEdge));
    for (int x = 0; x < resolution.x; x = x == kEdge - 1 ? std::max(kEdge, resolution.x - kEdge) : x + 1)
        std::copy_n(row + size_t(x) * stride, stride,
                    &edgeColumns_[(size_t(y) * columns + size_t(EdgeIndex(x, resolution.x))) * stride]);
}

const float* FileSource::Row(int y) {
    if (y >= band_.end) ReadBand(y);
    const size_t stride = header_.channels.size();
    const float* in = &band_.values[size_t(y - band_.begin) * size_t(header_.resolution.x) * stride];
    float* out = row_.data();
    for (int x = 0; x < header_.resolution.x; ++x, in += stride)
        for (const int c : channels_) *out++ = in[c];
    advance_();
    return row_.data();
}

float FileSource::EdgeValue(Int2 p, int channel) const {
    const size_t stride = header_.channels.size(), c = size_t(channels_[size_t(channel)]);
    const Int2 resolution = header_.resolution;
    if (IsAtEdge(p.y, resolution.y))
        return edgeRows_[(size_t(EdgeIndex(p.y, resolution.y)) * size_t(resolution.x) + size_t(p.x)) *
                             stride +
                         c];
    const size_t columns = size_t(std::min(resolution.x, 2 * kEdge));
    return edgeColumns_[(size_t(p.y) * columns + size_t(EdgeIndex(p.x, resolution.x))) * stride + c];
}

}  // namespace lacquer
