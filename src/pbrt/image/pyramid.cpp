#include "pbrt/image/pyramid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "pbrt/image/half.h"

namespace lacquer {

namespace {

/// Sinc of unit period under a sinc window of radius 2.
float WindowedSinc(float x) {
    constexpr float kRadius = 2;
    if (std::abs(x) > kRadius) return 0;
    return SinXOverX(Pi * x) * SinXOverX(Pi * x / kRadius);
}

/// The four source pixels of one pixel of an enlarged axis; at most two of them are outside.
struct Taps {
    int first = 0;
    float weights[4] = {};
};

std::vector<Taps> MakeTaps(int from, int to) {
    std::vector<Taps> taps(static_cast<size_t>(to));
    for (int i = 0; i < to; ++i) {
        Taps& t = taps[size_t(i)];
        const float center = (float(i) + 0.5f) * float(from) / float(to);
        t.first = int(std::floor(center - 1.5f));
        float sum = 0;
        for (int k = 0; k < 4; ++k) {
            t.weights[k] = WindowedSinc(float(t.first + k) + 0.5f - center);
            sum += t.weights[k];
        }
        for (float& w : t.weights) w /= sum;
    }
    return taps;
}

/// Rows of an image enlarged to another size, made one after the other; four rows enlarged along x are kept.
class Enlarger {
  public:
    Enlarger(PyramidSource& source, Int2 resolution, WrapMode wrap)
        : source_(source),
          from_(source.Resolution()),
          wrap_(wrap),
          resolution_(resolution),
          channels_(source.NumChannels()),
          xTaps_(MakeTaps(from_.x, resolution.x)),
          yTaps_(MakeTaps(from_.y, resolution.y)),
          low_(std::min(0.f, source.Lowest())) {
        for (Row& row : rows_) row.values.resize(size_t(resolution.x) * size_t(channels_));
    }

    void MakeRow(int y, std::vector<float>* out) {
        out->resize(rows_[0].values.size());
        if (resolution_ == from_) {
            std::copy_n(source_.Row(y), out->size(), out->data());
            return;
        }
        const Taps& taps = yTaps_[size_t(y)];
        const float* rows[4];
        for (int k = 0; k < 4; ++k) rows[k] = RowAlongX(taps.first + k);
        for (size_t i = 0; i < out->size(); ++i) {
            float sum = 0;
            for (int k = 0; k < 4; ++k) sum += taps.weights[k] * rows[k][i];
            // The sinc's negative lobes must not make negative values where there are none.
            (*out)[i] = std::max(low_, sum);
        }
    }

  private:
    struct Row {
        int y = std::numeric_limits<int>::min();
        std::vector<float> values;
    };

    float Beyond(Int2 p, int c) const { return WrapPixel(&p, from_, wrap_) ? source_.EdgeValue(p, c) : 0.f; }

    const float* RowAlongX(int y) {
        Row& row = rows_[Mod(y, 4)];
        if (row.y == y) return row.values.data();
        row.y = y;
        const float* const in = y >= 0 && y < from_.y ? source_.Row(y) : nullptr;
        float* out = row.values.data();
        for (int x = 0; x < resolution_.x; ++x) {
            const Taps& taps = xTaps_[size_t(x)];
            const bool inside = in && taps.first >= 0 && taps.first + 3 < from_.x;
            for (int c = 0; c < channels_; ++c) {
                float sum = 0;
                for (int k = 0; k < 4; ++k) {
                    const int tap = taps.first + k;
                    const bool isIn = inside || (in && tap >= 0 && tap < from_.x);
                    sum += taps.weights[k] * (isIn ? in[tap * channels_ + c] : Beyond({tap, y}, c));
                }
                *out++ = sum;
            }
        }
        return row.values.data();
    }

    PyramidSource& source_;
    Int2 from_;
    WrapMode wrap_;
    Int2 resolution_;
    int channels_;
    std::vector<Taps> xTaps_, yTaps_;
    Row rows_[4];
    float low_;
};

/// Rounds linear values to the bytes of an encoding: as 255 FromLinear(value) + 1/2 does, but without a power
/// for each value.
class ByteEncoder {
  public:
    explicit ByteEncoder(ColorEncoding encoding) {
        for (int code = 1; code < 256; ++code) first_[size_t(code)] = FirstValueOf(code, encoding);
        int code = 0;
        for (size_t i = 0; i < kSteps; ++i) {
            while (code < 255 && first_[size_t(code) + 1] <= float(i) / kSteps) ++code;
            start_[i] = uint8_t(code);
        }
    }
    uint8_t operator()(float value) const {
        if (!(value > 0)) return 0;
        if (value >= 1) return 255;
        int code = start_[size_t(value * kSteps)];
        while (code < 255 && value >= first_[size_t(code) + 1]) ++code;
        return uint8_t(code);
    }

  private:
    static constexpr size_t kSteps = 4096;
    /// The smallest float in [0,1] that becomes `code`, by bisection over the bits of floats.
    static float FirstValueOf(int code, ColorEncoding encoding) {
        uint32_t low = 0, high = std::bit_cast<uint32_t>(1.f);
        while (low < high) {
            const uint32_t middle = (low + high) / 2;
            const bool reaches = int(encoding.FromLinear(std::bit_cast<float>(middle)) * 255 + 0.5f) >= code;
            (reaches ? high : low) = reaches ? middle : middle + 1;
        }
        return std::bit_cast<float>(low);
    }
    std::array<float, 256> first_{};
    std::array<uint8_t, kSteps> start_{};
};

/// Rows of texels from rows of floats.
class RowEncoder {
  public:
    explicit RowEncoder(const TexelFormat& format)
        : format_(format), bytes_(format.encoding), table_(format.encoding.ByteTable()) {}

    /// The stored form of `row`, good until the next call.
    const uint8_t* Encode(const float* row, size_t count) {
        out_.resize(count * format_.ValueBytes());
        switch (format_.format) {
            case PixelFormat::Byte:
                for (size_t i = 0; i < count; ++i) out_[i] = bytes_(row[i]);
                break;
            case PixelFormat::Half:
                for (size_t i = 0; i < count; ++i) {
                    const uint16_t half = FloatToHalf(std::clamp(row[i], -kMaxHalf, kMaxHalf));
                    std::memcpy(&out_[2 * i], &half, sizeof half);
                }
                break;
            case PixelFormat::Float:
                std::memcpy(out_.data(), row, count * sizeof(float));
        }
        return out_.data();
    }

    /// What Encode has just stored, as floats.
    void Decode(float* row, size_t count) const {
        for (size_t i = 0; i < count; ++i) {
            uint16_t half;
            switch (format_.format) {
                case PixelFormat::Byte:
                    row[i] = table_[out_[i]];
                    break;
                case PixelFormat::Half:
                    std::memcpy(&half, &out_[2 * i], sizeof half);
                    row[i] = HalfToFloat(half);
                    break;
                case PixelFormat::Float:
                    return;
            }
        }
    }

  private:
    TexelFormat format_;
    ByteEncoder bytes_;
    std::array<float, 256> table_;
    std::vector<uint8_t> out_;
};

/// Each level adds its rows to the one above; a row is passed on once it is complete.
class Cascade {
  public:
    Cascade(std::vector<Int2> levels, const TexelFormat& format, PyramidSink& sink)
        : levels_(std::move(levels)), channels_(format.numChannels), encoder_(format), sink_(sink) {
        for (const Int2 resolution : levels_) sums_.emplace_back(size_t(resolution.x) * size_t(channels_));
    }

    /// The finest level is rounded to its format before it is averaged, as in pbrt.
    void AddRow(int y, std::vector<float>& row) {
        sink_.TakeRow(0, y, encoder_.Encode(row.data(), row.size()));
        encoder_.Decode(row.data(), row.size());
        AddToCoarser(0, y, row.data());
    }

  private:
    void AddToCoarser(size_t level, int y, const float* row) {
        if (level + 1 == levels_.size()) return;
        const Int2 resolution = levels_[level], half = levels_[level + 1];
        // Along an axis of one texel there is only one to average.
        const float weight = (resolution.x > 1 ? 0.5f : 1.f) * (resolution.y > 1 ? 0.5f : 1.f);
        std::vector<float>& sums = sums_[level + 1];
        for (int x = 0; x < resolution.x; ++x)
            for (int c = 0; c < channels_; ++c)
                sums[size_t(std::min(x / 2, half.x - 1) * channels_ + c)] += weight * row[x * channels_ + c];
        const bool isComplete = resolution.y == 1 || y % 2 == 1;
        if (!isComplete) return;
        sink_.TakeRow(int(level) + 1, y / 2, encoder_.Encode(sums.data(), sums.size()));
        AddToCoarser(level + 1, y / 2, sums.data());
        std::fill(sums.begin(), sums.end(), 0.f);
    }

    std::vector<Int2> levels_;
    int channels_;
    RowEncoder encoder_;
    PyramidSink& sink_;
    std::vector<std::vector<float>> sums_;  // of the row in the making, for each level
};

}  // namespace

std::vector<Int2> PyramidLevels(Int2 image) {
    std::vector<Int2> levels{{RoundUpPowerOf2(image.x), RoundUpPowerOf2(image.y)}};
    while (levels.back() != Int2(1)) levels.push_back(glm::max(Int2(1), levels.back() / 2));
    return levels;
}

size_t PyramidBytes(Int2 image, const TexelFormat& format) {
    size_t texels = 0;
    for (const Int2 level : PyramidLevels(image)) texels += size_t(level.x) * size_t(level.y);
    return texels * format.TexelBytes();
}

void MakePyramid(PyramidSource& source, const TexelFormat& format, WrapMode wrap, PyramidSink& sink) {
    std::vector<Int2> levels = PyramidLevels(source.Resolution());
    const Int2 resolution = levels[0];
    Cascade cascade(std::move(levels), format, sink);
    Enlarger enlarger(source, resolution, wrap);
    std::vector<float> row;
    for (int y = 0; y < resolution.y; ++y) {
        enlarger.MakeRow(y, &row);
        cascade.AddRow(y, row);
    }
}

}  // namespace lacquer
