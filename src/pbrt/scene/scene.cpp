#include "pbrt/scene/scene.h"

#include "pbrt/image/image_cache.h"

namespace lacquer {

namespace {

/// Moves an interaction found in an object's space to rendering space.
void TransformInteraction(const Transform& t, SurfaceInteraction* si) {
    const Point3 p = si->p;
    si->p = t.Point(p);
    // Error of the point before, stretched by the transform, and of the transform itself.
    const glm::mat4& m = t.Matrix();
    float stretch = 0, terms = 0;
    for (int row = 0; row < 3; ++row) {
        stretch = std::max(stretch, std::abs(m[0][row]) + std::abs(m[1][row]) + std::abs(m[2][row]));
        terms = std::max(terms, std::abs(m[0][row] * p.x) + std::abs(m[1][row] * p.y) +
                                    std::abs(m[2][row] * p.z) + std::abs(m[3][row]));
    }
    si->pError = stretch * si->pError + 8 * MachineEpsilon * terms;
    si->n = Normalize(t.Normal(si->n));
    si->dpdu = t.Vector(si->dpdu);
    si->dpdv = t.Vector(si->dpdv);
    auto& s = si->shading;
    s.n = FaceForward(Normalize(t.Normal(s.n)), si->n);
    s.dpdu = t.Vector(s.dpdu);
    s.dpdv = t.Vector(s.dpdv);
    if (!si->wantsNormalDerivatives) return;
    s.dndu = t.Normal(s.dndu);
    s.dndv = t.Normal(s.dndv);
}

}  // namespace

Scene::Scene(SceneParts parts) : parts_(std::move(parts)) {
    std::vector<std::vector<AccelGeometry>> groups;
    for (std::vector<Primitive>& group : parts_.groups) {
        groups.emplace_back();
        for (Primitive& p : group) {
            groups.back().push_back({p.shape.get(), p.alpha});
            const bool isInvisible = p.material && p.material->IsInvisible();
            (isInvisible ? hasInterfaces_ : hasScatteringSurfaces_) = true;
            hasSubsurface_ |= p.material && p.material->HasSubsurface();
            // Bumps of what a material is made of have footprints, too.
            p.wantsNormalDerivatives = p.material && p.material->NeedsFootprint();
        }
    }
    accelerator_ = std::make_unique<lacquer::Accelerator>(groups, parts_.instances);

    isMoving_ = parts_.camera->RenderFromCamera().IsAnimated() ||
                std::any_of(parts_.instances.begin(), parts_.instances.end(),
                            [](const auto& instance) { return instance.renderFromObject.IsAnimated(); });

    for (const auto& light : parts_.areaLights) lights_.push_back(light.get());
    for (const auto& light : parts_.lights) lights_.push_back(light.get());
    Bounds3 bounds = accelerator_->Bounds();
    if (bounds.IsEmpty()) bounds = Bounds3(Point3(-1), Point3(1));
    for (const auto& light : parts_.lights) light->Preprocess(bounds);
    for (const auto& light : parts_.areaLights) light->Preprocess(bounds);
    for (const Light* light : lights_) {
        if (light->IsInfinite()) infiniteLights_.push_back(light);
        if (!light->IsUniformInfinite()) sampledLights_.push_back(light);
    }
}

bool Scene::NearestHit(const Ray& ray, float tMax, SurfaceInteraction* si) const {
    Hit hit;
    if (!accelerator_->Intersect(ray, tMax, &hit)) return false;
    const Primitive& primitive = parts_.groups[size_t(hit.group)][size_t(hit.geometry)];
    const ShapeHit shapeHit{hit.t, hit.coordinates};
    si->wantsNormalDerivatives = primitive.wantsNormalDerivatives;
    if (hit.instance < 0) {
        primitive.shape->Interaction(ray, shapeHit, hit.primitive, si);
        si->object = primitive.object;
    } else {
        si->object = parts_.instanceObjects[size_t(hit.instance)];
        const AnimatedTransform& moving = parts_.instances[size_t(hit.instance)].renderFromObject;
        const auto interact = [&](const Transform& t) {
            primitive.shape->Interaction(t.InverseRay(ray), shapeHit, hit.primitive, si);
            TransformInteraction(t, si);
        };
        if (moving.IsAnimated())
            interact(moving.At(ray.time));
        else
            interact(moving.Start());
    }
    si->instance = hit.instance;
    si->wo = -ray.d;
    si->time = ray.time;
    si->material = primitive.material;
    si->mediumInterface = &primitive.media;
    si->areaLight = primitive.firstLight < 0
                        ? nullptr
                        : parts_.areaLights[size_t(primitive.firstLight + hit.primitive)].get();
    return true;
}

bool Scene::Visible(const SurfaceInteraction& from, const LightSample& to, bool throughInterfaces,
                    RayCounts& counts) const {
    const Ray ray = RayToLight(LightReference(from), to, from.time);
    if (throughInterfaces && hasInterfaces_)
        return FollowToLight(ray, counts, [](const Ray&, float, const SurfaceInteraction*) { return true; });
    return !Occluded(ray, kShadowRayEnd, counts);
}

bool Scene::TexturesFailed() const { return parts_.textures && parts_.textures->Images().HasFailed(); }

void Scene::CheckTextures() const {
    if (parts_.textures) parts_.textures->Images().CheckTiles();
}

int64_t Scene::NumPrimitives() const {
    int64_t count = 0;
    for (const auto& group : parts_.groups)
        for (const Primitive& p : group) count += p.shape->NumPrimitives();
    return count;
}

size_t Scene::GeometryBytes() const {
    size_t bytes = 0;
    for (const auto& group : parts_.groups)
        for (const Primitive& p : group) bytes += p.shape->MemoryBytes();
    return bytes;
}

}  // namespace lacquer
