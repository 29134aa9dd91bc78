// Files that several scenes have in common, one after another: the frames of a sequence.
#pragma once

#include "pbrt/image/image_cache.h"
#include "pbrt/shapes/mesh_cache.h"

namespace lacquer {

/// What BuildScene() reads from files that are large: images, pyramids of textures, meshes. It keeps them for
/// the next scene, and after a scene is built drops what that has not asked for. Outlives the scenes; one
/// scene at a time.
struct AssetCache {
    /// @param observer  as of ImageCache
    explicit AssetCache(const TextureMemory& memory, Observer* observer) : images(memory, observer) {}
    void BeginScene() {
        images.BeginScene();
        meshes.BeginScene();
    }
    void DropUnused() {
        images.DropUnused();
        meshes.DropUnused();
    }

    ImageCache images;
    MeshCache meshes;
};

}  // namespace lacquer
