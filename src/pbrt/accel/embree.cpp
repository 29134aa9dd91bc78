// The accelerator over Embree 3 or 4. Triangle meshes are Embree's own triangles. All other shapes of a group
// are one user geometry that calls Shape::Intersect: a scene may have a shape for each hair, and a geometry
// of its own would cost far more than the hair. A still instance is Embree's instance, and a moving (or
// extreme) one a user geometry that interpolates its transform exactly as the rest of the renderer does. The
// world's shapes and moving instances are not known to Embree where they are few: it would walk a hierarchy
// for each of these kinds with every ray.
#if LACQUER_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <new>

#include "pbrt/accel/accelerator.h"
#include "pbrt/accel/few_boxes.h"
#include "pbrt/core/check.h"

namespace lacquer {

namespace {

/// What the callbacks of a triangle mesh know; owned by the implementation, at a fixed address.
struct MeshData {
    AccelGeometry geometry;
};
/// A shape that Embree does not know.
struct ShapeData {
    AccelGeometry geometry;
    unsigned id = 0;  ///< index in its group
};
/// All such shapes of a group: what the callbacks of a user geometry know, or a few of the world.
struct ShapeSet {
    struct Primitive {
        unsigned shape;      ///< index in `shapes`
        unsigned primitive;  ///< of that shape
    };
    std::vector<ShapeData> shapes;
    std::vector<Primitive> primitives;
    /// Of the primitives, a little padded, where Embree does not compare bounds: of a few of the world, and
    /// of one that is alone in its user geometry. Else none.
    FewBoxes boxes;

    void Add(const AccelGeometry& geometry, unsigned id);
    Bounds3 BoundsOf(Primitive p) const { return shapes[p.shape].geometry.shape->Bounds(int(p.primitive)); }
};
struct MovingInstanceData {
    AccelInstance instance;
    RTCScene object = nullptr;
    Bounds3 bounds;
    unsigned id = 0;
};

// What Embree 4 calls otherwise. `instance` is what the ray is in already.
#if LACQUER_EMBREE >= 4
void TraceNearest(RTCScene scene, RTCRayHit* rayHit, unsigned instance = RTC_INVALID_GEOMETRY_ID) {
    RTCRayQueryContext context;
    rtcInitRayQueryContext(&context);
    context.instID[0] = instance;
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene, rayHit, &arguments);
}
void TraceShadow(RTCScene scene, RTCRay* ray, unsigned instance = RTC_INVALID_GEOMETRY_ID) {
    RTCRayQueryContext context;
    rtcInitRayQueryContext(&context);
    context.instID[0] = instance;
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.context = &context;
    rtcOccluded1(scene, ray, &arguments);
}
#else
void TraceNearest(RTCScene scene, RTCRayHit* rayHit, unsigned instance = RTC_INVALID_GEOMETRY_ID) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.instID[0] = instance;
    rtcIntersect1(scene, &context, rayHit);
}
void TraceShadow(RTCScene scene, RTCRay* ray, unsigned instance = RTC_INVALID_GEOMETRY_ID) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.instID[0] = instance;
    rtcOccluded1(scene, &context, ray);
}
#endif

RTCBounds ToEmbree(const Bounds3& b) { return {b.min.x, b.min.y, b.min.z, 0, b.max.x, b.max.y, b.max.z, 0}; }

Ray ToRay(const RTCRay& r) { return {{r.org_x, r.org_y, r.org_z}, {r.dir_x, r.dir_y, r.dir_z}, r.time}; }

RTCRay ToEmbree(const Ray& r, float tMax) {
    RTCRay ray;
    ray.org_x = r.o.x;
    ray.org_y = r.o.y;
    ray.org_z = r.o.z;
    ray.dir_x = r.d.x;
    ray.dir_y = r.d.y;
    ray.dir_z = r.d.z;
    ray.tnear = 0;
    ray.tfar = tMax;
    ray.time = r.time;
    ray.mask = ~0u;
    ray.id = 0;
    ray.flags = 0;
    return ray;
}

constexpr float kLargestComponent = 1.8e18f;  ///< Embree takes components up to 1.844e18

/// Embree ends the process on larger ones: such a ray meets nothing.
bool IsTraceable(const RTCRay& ray) {
    const float largest = std::max({std::abs(ray.org_x), std::abs(ray.org_y), std::abs(ray.org_z),
                                    std::abs(ray.dir_x), std::abs(ray.dir_y), std::abs(ray.dir_z)});
    // A NaN in a sum is seen where a maximum may lose it.
    const float sum =
        ray.org_x + ray.org_y + ray.org_z + ray.dir_x + ray.dir_y + ray.dir_z + ray.tnear + ray.tfar;
    return largest < kLargestComponent && !std::isnan(sum);
}

/// Embree leaves out what is larger than its rays may be, or nowhere: so does what is not known to it.
bool FitsEmbree(const Bounds3& b) {
    return !b.IsEmpty() && MaxComponent(glm::max(Abs(b.min), Abs(b.max))) < kLargestComponent;
}

/// Embree transforms the rays of its own instances without a look: those that might leave its range take our
/// way.
bool IsExtreme(const AnimatedTransform& renderFromObject) {
    constexpr float kLargest = 1e9f;
    const glm::mat4& inverse = renderFromObject.Start().InverseMatrix();
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::abs(inverse[column][row]) < kLargest)) return true;
    return false;
}

// --- shapes that Embree does not know ---

Bounds3 Padded(const Bounds3& b) {
    const Vec3 pad(1e-5f * MaxComponent(glm::max(Abs(b.min), Abs(b.max))));
    return {b.min - pad, b.max + pad};
}

void ShapeSet::Add(const AccelGeometry& geometry, unsigned id) {
    const unsigned count = unsigned(geometry.shape->NumPrimitives());
    for (unsigned i = 0; i < count; ++i) primitives.push_back({unsigned(shapes.size()), i});
    shapes.push_back({geometry, id});
}

void ShapeBounds(const RTCBoundsFunctionArguments* args) {
    const auto* set = static_cast<const ShapeSet*>(args->geometryUserPtr);
    *args->bounds_o = ToEmbree(set->BoundsOf(set->primitives[args->primID]));
}

/// False if the ray surely misses a primitive that is alone: Embree calls it for every ray, without a look at
/// its bounds, and the box costs less than a quadric's test.
bool MayMeet(const ShapeSet& set, const RTCRay& r) {
    return set.boxes.Size() == 0 || set.boxes.AnyMet(ToRay(r), r.tnear, r.tfar, [](int) { return true; });
}

std::optional<ShapeHit> IntersectShape(const ShapeData& data, const RTCRay& r, unsigned primitive) {
    const Ray ray = ToRay(r);
    const Shape& shape = *data.geometry.shape;
    // Behind a hole of a curved shape there may be its other side.
    constexpr int kMaxSides = 64;
    float tMin = r.tnear;
    for (int i = 0; i < kMaxSides; ++i) {
        const std::optional<ShapeHit> hit = shape.Intersect(ray, tMin, r.tfar, int(primitive));
        if (!hit) return std::nullopt;
        if (!data.geometry.alpha || !PassesAlpha(*data.geometry.alpha, shape, ray, *hit, int(primitive)))
            return hit;
        tMin = std::nextafter(hit->t, Infinity);  // t was rounded, perhaps down
    }
    return std::nullopt;
}

/// @param instance  what the ray is in
void IntersectPrimitive(const ShapeSet& set, ShapeSet::Primitive p, unsigned instance, RTCRayHit* rayHit) {
    const ShapeData& data = set.shapes[p.shape];
    const std::optional<ShapeHit> hit = IntersectShape(data, rayHit->ray, p.primitive);
    if (!hit) return;
    rayHit->ray.tfar = hit->t;
    rayHit->hit.u = hit->coordinates.x;
    rayHit->hit.v = hit->coordinates.y;
    // The names of the shape, not of the user geometry: Embree hands them on without a look.
    rayHit->hit.primID = p.primitive;
    rayHit->hit.geomID = data.id;
    rayHit->hit.instID[0] = instance;
}

void ShapeIntersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    const auto* set = static_cast<const ShapeSet*>(args->geometryUserPtr);
    auto* rayHit = reinterpret_cast<RTCRayHit*>(args->rayhit);
    if (MayMeet(*set, rayHit->ray))
        IntersectPrimitive(*set, set->primitives[args->primID], args->context->instID[0], rayHit);
}

void ShapeOccluded(const RTCOccludedFunctionNArguments* args) {
    if (!args->valid[0]) return;
    const auto* set = static_cast<const ShapeSet*>(args->geometryUserPtr);
    const ShapeSet::Primitive p = set->primitives[args->primID];
    auto* ray = reinterpret_cast<RTCRay*>(args->ray);
    if (MayMeet(*set, *ray) && IntersectShape(set->shapes[p.shape], *ray, p.primitive)) ray->tfar = -Infinity;
}

// --- holes in triangles ---

void TriangleAlpha(const RTCFilterFunctionNArguments* args) {
    if (args->valid[0] != -1) return;
    const auto* data = static_cast<const MeshData*>(args->geometryUserPtr);
    const auto& ray = *reinterpret_cast<const RTCRay*>(args->ray);
    const auto& hit = *reinterpret_cast<const RTCHit*>(args->hit);
    const ShapeHit shapeHit{ray.tfar, {hit.u, hit.v}};
    if (PassesAlpha(*data->geometry.alpha, *data->geometry.shape, ToRay(ray), shapeHit, int(hit.primID)))
        args->valid[0] = 0;
}

// --- moving instances ---

void MovingBounds(const RTCBoundsFunctionArguments* args) {
    *args->bounds_o = ToEmbree(static_cast<const MovingInstanceData*>(args->geometryUserPtr)->bounds);
}

RTCRay InObject(const MovingInstanceData& data, const RTCRay& ray) {
    const Ray world = ToRay(ray);
    RTCRay local = ToEmbree(data.instance.renderFromObject.At(world.time).InverseRay(world), ray.tfar);
    local.tnear = ray.tnear;
    return local;
}

void IntersectMoving(const MovingInstanceData& data, RTCRayHit* rayHit) {
    RTCRayHit local;
    local.ray = InObject(data, rayHit->ray);
    if (!IsTraceable(local.ray)) return;
    local.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    TraceNearest(data.object, &local, data.id);
    if (local.hit.geomID == RTC_INVALID_GEOMETRY_ID) return;
    rayHit->ray.tfar = local.ray.tfar;
    rayHit->hit = local.hit;
    rayHit->hit.instID[0] = data.id;
}

bool OccludedByMoving(const MovingInstanceData& data, const RTCRay& ray) {
    RTCRay local = InObject(data, ray);
    if (!IsTraceable(local)) return false;
    TraceShadow(data.object, &local, data.id);
    return local.tfar < 0;
}

void MovingIntersect(const RTCIntersectFunctionNArguments* args) {
    if (!args->valid[0]) return;
    IntersectMoving(*static_cast<const MovingInstanceData*>(args->geometryUserPtr),
                    reinterpret_cast<RTCRayHit*>(args->rayhit));
}

void MovingOccluded(const RTCOccludedFunctionNArguments* args) {
    if (!args->valid[0]) return;
    auto* ray = reinterpret_cast<RTCRay*>(args->ray);
    if (OccludedByMoving(*static_cast<const MovingInstanceData*>(args->geometryUserPtr), *ray))
        ray->tfar = -Infinity;
}

bool CountMemory(void* counter, ssize_t bytes, bool /*post*/) {
    *static_cast<std::atomic<int64_t>*>(counter) += bytes;
    return true;
}

}  // namespace

struct Accelerator::Implementation {
    RTCDevice device = nullptr;
    std::vector<RTCScene> scenes;  // one for each group
    std::vector<std::unique_ptr<MeshData>> meshes;
    std::vector<std::unique_ptr<ShapeSet>> shapeSets;
    /// Of the world, if they are few: each ray meets them before it goes to Embree.
    ShapeSet fewShapes;
    std::vector<std::unique_ptr<MovingInstanceData>> moving;
    FewBoxes boxesOfMoving;  ///< if they are few, which Embree does not know either
    std::vector<AccelInstance> instances;
    unsigned numWorldGeometries = 0;
    std::atomic<int64_t> bytes = 0;

    Implementation() : device(rtcNewDevice(nullptr)) {
        if (!device) throw std::bad_alloc();  // it asks for nothing but memory and threads
        rtcSetDeviceMemoryMonitorFunction(device, CountMemory, &bytes);
    }
    ~Implementation() {
        for (RTCScene scene : scenes) rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }

    RTCScene NewScene() {
        RTCScene scene = rtcNewScene(device);
        rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
        scenes.push_back(scene);
        return scene;
    }
    void Attach(RTCScene scene, RTCGeometry geometry, unsigned id) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, id);
        rtcReleaseGeometry(geometry);
    }
    void AddGroup(RTCScene scene, const std::vector<AccelGeometry>& group, bool isWorld);
    void AddMesh(RTCScene scene, const AccelGeometry& g, const TriangleView& mesh, unsigned id);
    void AddShapes(RTCScene scene, std::unique_ptr<ShapeSet> set);
    void KeepFew(ShapeSet set);
    void AddInstance(RTCScene scene, const AccelInstance& instance, unsigned id);
    void AttachMoving(RTCScene scene);

    void Intersect(RTCRayHit* rayHit) const;
    bool Occluded(RTCRay* ray) const;
    Bounds3 Bounds() const;
};

void Accelerator::Implementation::AddMesh(RTCScene scene, const AccelGeometry& g, const TriangleView& mesh,
                                          unsigned id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.vertices.data(),
                               0, sizeof(Point3), mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                               sizeof(glm::uvec3), mesh.triangles.size());
    if (g.alpha) {
        meshes.push_back(std::make_unique<MeshData>(MeshData{g}));
        rtcSetGeometryUserData(geometry, meshes.back().get());
        rtcSetGeometryIntersectFilterFunction(geometry, TriangleAlpha);
        rtcSetGeometryOccludedFilterFunction(geometry, TriangleAlpha);
    }
    Attach(scene, geometry, id);
}

void Accelerator::Implementation::AddShapes(RTCScene scene, std::unique_ptr<ShapeSet> set) {
    if (set->primitives.size() == 1) set->boxes.Add(Padded(set->BoundsOf(set->primitives[0])));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, unsigned(set->primitives.size()));
    rtcSetGeometryBoundsFunction(geometry, ShapeBounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, ShapeIntersect);
    rtcSetGeometryOccludedFunction(geometry, ShapeOccluded);
    rtcSetGeometryUserData(geometry, set.get());
    // The identifier of any of its shapes is free.
    Attach(scene, geometry, set->shapes[0].id);
    shapeSets.push_back(std::move(set));
}

void Accelerator::Implementation::KeepFew(ShapeSet set) {
    std::erase_if(set.primitives, [&](ShapeSet::Primitive p) { return !FitsEmbree(set.BoundsOf(p)); });
    for (const ShapeSet::Primitive p : set.primitives) set.boxes.Add(Padded(set.BoundsOf(p)));
    fewShapes = std::move(set);
}

// Shapes are met before what is in Embree, which then looks less far; moving instances after it, for they
// cost the most.
void Accelerator::Implementation::Intersect(RTCRayHit* rayHit) const {
    const RTCRay& ray = rayHit->ray;
    fewShapes.boxes.AnyMet(ToRay(ray), ray.tnear, ray.tfar, [&](int i) {
        IntersectPrimitive(fewShapes, fewShapes.primitives[size_t(i)], RTC_INVALID_GEOMETRY_ID, rayHit);
        return false;
    });
    TraceNearest(scenes[0], rayHit);
    boxesOfMoving.AnyMet(ToRay(ray), ray.tnear, ray.tfar, [&](int i) {
        IntersectMoving(*moving[size_t(i)], rayHit);
        return false;
    });
}

bool Accelerator::Implementation::Occluded(RTCRay* ray) const {
    const Ray world = ToRay(*ray);
    const float tMin = ray->tnear, tMax = ray->tfar;
    const bool isByFew = fewShapes.boxes.AnyMet(world, tMin, tMax, [&](int i) {
        const ShapeSet::Primitive p = fewShapes.primitives[size_t(i)];
        return IntersectShape(fewShapes.shapes[p.shape], *ray, p.primitive).has_value();
    });
    if (isByFew) return true;
    TraceShadow(scenes[0], ray);
    if (ray->tfar < 0) return true;
    return boxesOfMoving.AnyMet(world, tMin, tMax,
                                [&](int i) { return OccludedByMoving(*moving[size_t(i)], *ray); });
}

Bounds3 Accelerator::Implementation::Bounds() const {
    RTCBounds b;
    rtcGetSceneBounds(scenes[0], &b);
    Bounds3 bounds;
    bounds.min = {b.lower_x, b.lower_y, b.lower_z};
    bounds.max = {b.upper_x, b.upper_y, b.upper_z};
    for (const ShapeSet::Primitive p : fewShapes.primitives) bounds = bounds.Union(fewShapes.BoundsOf(p));
    for (const auto& data : moving) bounds = bounds.Union(data->bounds);
    return bounds;
}

void Accelerator::Implementation::AddGroup(RTCScene scene, const std::vector<AccelGeometry>& group,
                                           bool isWorld) {
    auto set = std::make_unique<ShapeSet>();
    for (size_t i = 0; i < group.size(); ++i) {
        if (const std::optional<TriangleView> mesh = group[i].shape->Triangles())
            AddMesh(scene, group[i], *mesh, unsigned(i));
        else
            set->Add(group[i], unsigned(i));
    }
    if (isWorld && set->primitives.size() <= FewBoxes::kMax)
        KeepFew(std::move(*set));
    else if (!set->shapes.empty())
        AddShapes(scene, std::move(set));
}

void Accelerator::Implementation::AddInstance(RTCScene scene, const AccelInstance& instance, unsigned id) {
    RTCScene object = scenes[size_t(instance.group)];
    if (!instance.renderFromObject.IsAnimated() && !IsExtreme(instance.renderFromObject)) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, object);
        const glm::mat4& m = instance.renderFromObject.Start().Matrix();
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT4X4_COLUMN_MAJOR, &m[0][0]);
        Attach(scene, geometry, id);
        return;
    }
    RTCBounds objectBounds;
    rtcGetSceneBounds(object, &objectBounds);
    moving.push_back(std::make_unique<MovingInstanceData>());
    MovingInstanceData& data = *moving.back();
    data.instance = instance;
    data.object = object;
    data.id = id;
    data.bounds = instance.renderFromObject.MotionBounds(
        Bounds3({objectBounds.lower_x, objectBounds.lower_y, objectBounds.lower_z},
                {objectBounds.upper_x, objectBounds.upper_y, objectBounds.upper_z}));
}

void Accelerator::Implementation::AttachMoving(RTCScene scene) {
    std::erase_if(moving, [](const auto& data) { return !FitsEmbree(data->bounds); });
    if (moving.size() <= FewBoxes::kMax) {
        for (const auto& data : moving) boxesOfMoving.Add(Padded(data->bounds));
        return;
    }
    for (const auto& data : moving) {
        RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, 1);
        rtcSetGeometryUserData(geometry, data.get());
        rtcSetGeometryBoundsFunction(geometry, MovingBounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, MovingIntersect);
        rtcSetGeometryOccludedFunction(geometry, MovingOccluded);
        Attach(scene, geometry, data->id);
    }
}

Accelerator::Accelerator(const std::vector<std::vector<AccelGeometry>>& groups,
                         std::vector<AccelInstance> instances)
    : impl_(std::make_unique<Implementation>()) {
    LACQUER_CHECK(!groups.empty());
    impl_->instances = std::move(instances);
    impl_->numWorldGeometries = unsigned(groups[0].size());
    for (const auto& group : groups) impl_->AddGroup(impl_->NewScene(), group, &group == &groups[0]);
    // Objects first: an instance needs the bounds of what it places.
    for (size_t i = 1; i < groups.size(); ++i) rtcCommitScene(impl_->scenes[i]);
    for (size_t i = 0; i < impl_->instances.size(); ++i)
        impl_->AddInstance(impl_->scenes[0], impl_->instances[i], impl_->numWorldGeometries + unsigned(i));
    impl_->AttachMoving(impl_->scenes[0]);
    rtcCommitScene(impl_->scenes[0]);
}

Accelerator::~Accelerator() = default;

bool Accelerator::Intersect(const Ray& ray, float tMax, Hit* hit) const {
    RTCRayHit rayHit;
    rayHit.ray = ToEmbree(ray, tMax);
    if (!IsTraceable(rayHit.ray)) return false;
    rayHit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rayHit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    impl_->Intersect(&rayHit);
    if (rayHit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    hit->t = rayHit.ray.tfar;
    hit->coordinates = {rayHit.hit.u, rayHit.hit.v};
    hit->geometry = int(rayHit.hit.geomID);
    hit->primitive = int(rayHit.hit.primID);
    hit->group = 0;
    hit->instance = -1;
    if (rayHit.hit.instID[0] != RTC_INVALID_GEOMETRY_ID) {
        hit->instance = int(rayHit.hit.instID[0] - impl_->numWorldGeometries);
        hit->group = impl_->instances[size_t(hit->instance)].group;
    }
    return true;
}

bool Accelerator::Occluded(const Ray& ray, float tMax) const {
    RTCRay r = ToEmbree(ray, tMax);
    return IsTraceable(r) && impl_->Occluded(&r);
}

Bounds3 Accelerator::Bounds() const { return impl_->Bounds(); }

size_t Accelerator::MemoryBytes() const {
    size_t bytes = size_t(std::max<int64_t>(0, impl_->bytes));
    for (const auto& set : impl_->shapeSets)
        bytes += set->shapes.capacity() * sizeof(ShapeData) +
                 set->primitives.capacity() * sizeof(ShapeSet::Primitive);
    return bytes;
}

}  // namespace lacquer
