// Float grids of NanoVDB files.
#pragma once

#include <string>
#include <vector>

#include "pbrt/core/file_bytes.h"
#include "pbrt/core/transform.h"
#include "pbrt/media/sparse_grid.h"

namespace lacquer {

/// A grid with its place in the medium's space.
struct NanoVdbGrid {
    SparseGrid values;          ///< by index
    Transform mediumFromIndex;  ///< "world" of the file is medium space
    Bounds3 bounds;             ///< of the active voxels, by index, from the first to one beyond the last
};

/// A file in memory. Formats: NanoVDB 32, uncompressed, zip and Blosc.
///
/// NanoVDB files are memory images full of offsets. Nothing is used before it was seen to lie within the
/// file; checksums are compared where the version is that of our headers, the only one whose rule is known.
class NanoVdbFile {
  public:
    /// Reads the file and its list of grids. Errors: as ReadFileBytes(); SceneError at `loc` for what is no
    /// such file.
    NanoVdbFile(const std::string& path, const FileLoc& loc);

    /// Names of the grids, in the file's order.
    std::vector<std::string> Names() const;
    /// Unpacks the first grid called `name`.
    /// @param clampNegative  negative values become 0
    /// Errors: SceneError if there is none (the message lists those that there are), it is no fog volume of
    /// floats, it is damaged, it has values that are not finite, or it spans more than kMaxBlocks blocks of
    /// 8^3 voxels.
    NanoVdbGrid Read(const std::string& name, bool clampNegative) const;

    static constexpr size_t kMaxBlocks = size_t(1) << 24;

  private:
    struct Entry {
        std::string name;
        uint32_t version = 0;
        uint16_t codec = 0;
        std::string_view packed;  ///< in file_
        uint64_t size = 0;        ///< unpacked
    };
    size_t ReadSegment(size_t position);
    [[noreturn]] void Fail(const std::string& problem) const;

    std::string path_;
    FileLoc loc_;
    FileBytes file_;
    std::vector<Entry> entries_;
};

}  // namespace lacquer
