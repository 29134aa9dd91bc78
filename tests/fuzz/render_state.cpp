// States of renders, as --resume, merge and info read them.
#include <zlib.h>

#include <cstring>
#include <optional>

#include "fuzz/fuzz_target.h"
#include "pbrt/film/state_file.h"

namespace lacquer::fuzz {
namespace {

// Makes the checksums of a state right, which no mutation does; the layout is that of film/state_file.cpp.
class Checksums {
  public:
    explicit Checksums(std::string_view bytes) : file_(bytes) {}

    std::string Repaired() {
        at_ = kMagic;
        Text();
        const uint64_t arrays = Number();
        for (uint64_t i = 0; i < arrays && at_ < file_.size(); ++i) {
            Text();
            const uint64_t kind = Number();
            Blocks();
            if (kind == 0) Blocks();
        }
        return std::move(file_);
    }

  private:
    static constexpr size_t kMagic = 16, kBlock = size_t(1) << 20;
    bool Has(uint64_t count) const { return at_ <= file_.size() && count <= file_.size() - at_; }
    uint64_t Number() {
        uint64_t number = 0;
        if (Has(sizeof number)) std::memcpy(&number, &file_[at_], sizeof number);
        at_ += sizeof number;
        return number;
    }
    void Write(size_t at, size_t first, size_t size) {
        const auto* bytes = reinterpret_cast<const unsigned char*>(file_.data()) + first;
        const uint64_t checksum = crc32_z(crc32_z(0, nullptr, 0), bytes, size);
        std::memcpy(&file_[at], &checksum, sizeof checksum);
    }
    void Text() {
        const uint64_t size = Number();
        if (!Has(size) || file_.size() - at_ - size < sizeof(uint64_t)) return End();
        Write(at_ + size, at_, size);
        at_ += size + sizeof(uint64_t);
    }
    void Blocks() {
        const uint64_t size = Number();
        for (uint64_t begin = 0; begin < size && at_ < file_.size(); begin += kBlock) {
            const uint64_t packed = Number();
            if (!Has(sizeof packed) || packed > file_.size() - at_ - sizeof packed) return End();
            Write(at_, at_ + sizeof packed, packed);
            at_ += sizeof packed + packed;
        }
    }
    void End() { at_ = file_.size(); }

    std::string file_;
    size_t at_ = 0;
};

void RenderState(std::string_view bytes) {
    const InputFile file(Checksums(bytes).Repaired());
    IsStateFile(file.Path());
    const std::string header = ReadStateHeader(file.Path());
    Require(ReadStateFile(file.Path()).header == header, "a state has one header");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "render_state", RenderState);

}  // namespace lacquer::fuzz
