// PLY files that stay from scene to scene.
#pragma once

#include <memory>
#include <string>

#include "pbrt/core/kept_files.h"
#include "pbrt/shapes/ply_reader.h"

namespace lacquer {

/// Reads each file once. Memory: what the files hold, beside the meshes that are made of it.
class MeshCache {
  public:
    /// Errors: those of ReadPly().
    std::shared_ptr<const PlyMesh> Get(const std::string& path, const FileLoc& loc) {
        return files_.Get(path, path, [&] { return ReadPly(path, loc); });
    }
    /// As of KeptFiles.
    void BeginScene() { files_.BeginScene(); }
    void DropUnused() { files_.DropUnused(); }

  private:
    KeptFiles<std::string, PlyMesh> files_;
};

}  // namespace lacquer
