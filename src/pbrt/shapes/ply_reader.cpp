#include "pbrt/shapes/ply_reader.h"

#include <fmt/format.h>

#include <array>

#include "pbrt/core/file_bytes.h"
#include "pbrt/shapes/ply_source.h"

namespace lacquer {

namespace {

constexpr size_t kMaxFileBytes = size_t(8) << 30;
constexpr int64_t kMaxElements = (int64_t(1) << 31) - 1;

// Position of a scalar property, -1 if there is none.
int FindScalar(const PlyElement& element, std::string_view name) {
    for (size_t i = 0; i < element.properties.size(); ++i)
        if (element.properties[i].name == name && !element.properties[i].countType) return int(i);
    return -1;
}

// Which property goes to which of x, y, z, nx, ny, nz, u, v.
struct VertexLayout {
    static constexpr int kChannels = 8;

    explicit VertexLayout(const PlyElement& element, const PlyContext& context)
        : channelOf(element.properties.size(), -1) {
        if (!Assign(element, {"x", "y", "z"}, 0))
            context.FailAtLine(element.line,
                               "the vertices have no positions; properties x, y and z are expected");
        hasNormals = Assign(element, {"nx", "ny", "nz"}, 3);
        for (const auto& names :
             {std::array{"u", "v"}, std::array{"s", "t"}, std::array{"texture_u", "texture_v"},
              std::array{"texture_s", "texture_t"}}) {
            hasUv = Assign(element, {names[0], names[1]}, 6);
            if (hasUv) break;
        }
    }

    std::vector<int> channelOf;
    bool hasNormals = false, hasUv = false;

  private:
    bool Assign(const PlyElement& element, std::initializer_list<const char*> names, int channel) {
        for (const char* name : names)
            if (FindScalar(element, name) < 0) return false;
        for (const char* name : names) channelOf[size_t(FindScalar(element, name))] = channel++;
        return true;
    }
};

template <class Source>
int64_t ReadListCount(Source& source, const PlyProperty& property) {
    const int64_t count = source.Integer(*property.countType);
    if (count < 0) source.Fail(fmt::format("a list of {} items", count));
    return count;
}

template <class Source>
void SkipProperty(Source& source, const PlyProperty& property) {
    source.Skip(property.type, property.countType ? ReadListCount(source, property) : 1);
}

template <class Source>
void ReadVertices(Source& source, const PlyElement& element, const PlyContext& context,
                  VertexArrays* vertices) {
    const VertexLayout layout(element, context);
    const size_t count = size_t(element.count);
    vertices->p.reserve(count + 2);  // and what Embree reads past the end
    if (layout.hasNormals) vertices->n.reserve(count);
    if (layout.hasUv) vertices->uv.reserve(count);
    const size_t numProperties = element.properties.size();
    for (size_t i = 0; i < count; ++i) {
        float c[VertexLayout::kChannels] = {};
        for (size_t k = 0; k < numProperties; ++k) {
            const PlyProperty& property = element.properties[k];
            if (const int channel = layout.channelOf[k]; channel >= 0)
                c[channel] = source.Float(property.type);
            else
                SkipProperty(source, property);
        }
        if (!IsFinite(Point3(c[0], c[1], c[2])))
            source.Fail(
                fmt::format("vertex {} has a coordinate that is not finite or too large for a float", i));
        vertices->p.emplace_back(c[0], c[1], c[2]);
        if (layout.hasNormals) vertices->n.emplace_back(c[3], c[4], c[5]);
        if (layout.hasUv) vertices->uv.emplace_back(c[6], c[7]);
    }
}

template <class Source>
void ReadFaces(Source& source, const PlyElement& element, int64_t numVertices, const PlyContext& context,
               PlyMesh* mesh) {
    const std::vector<PlyProperty>& properties = element.properties;
    const PlyProperty *corners = nullptr, *faceIndex = nullptr;
    for (const PlyProperty& property : properties) {
        if (property.countType && (property.name == "vertex_indices" || property.name == "vertex_index"))
            corners = &property;
        if (!property.countType && property.name == "face_indices") faceIndex = &property;
    }
    if (!corners)
        context.FailAtLine(element.line,
                           "the faces have no corners; a list property vertex_indices is expected");

    mesh->triangles.reserve(size_t(element.count) + 2);
    for (int64_t i = 0; i < element.count; ++i) {
        int64_t count = 0, index = 0;
        glm::uvec4 v(0);
        for (const PlyProperty& property : properties) {
            if (&property == corners) {
                count = ReadListCount(source, property);
                if (count != 3 && count != 4) {
                    source.Skip(property.type, count);
                    continue;
                }
                for (int k = 0; k < int(count); ++k) {
                    const int64_t vertex = source.Integer(property.type);
                    if (vertex < 0 || vertex >= numVertices)
                        source.Fail(fmt::format("face {} has the vertex {}; a number in [0, {}] is expected",
                                                i, vertex, numVertices - 1));
                    v[k] = glm::uint(vertex);
                }
            } else if (&property == faceIndex) {
                index = source.Integer(property.type);
                if (index < INT32_MIN || index > INT32_MAX)
                    source.Fail(fmt::format("face {} has the face index {}; 32 bits are expected", i, index));
            } else {
                SkipProperty(source, property);
            }
        }
        if (count == 3) {
            mesh->triangles.emplace_back(v.x, v.y, v.z);
            if (faceIndex) mesh->triangleFaceIndices.push_back(int(index));
        } else if (count == 4) {
            mesh->quads.push_back(v);
            if (faceIndex) mesh->quadFaceIndices.push_back(int(index));
        } else {
            ++mesh->numIgnoredFaces;
        }
    }
}

template <class Source>
void ReadElements(Source source, const PlyHeader& header, int64_t numVertices, const PlyContext& context,
                  PlyMesh* mesh) {
    for (const PlyElement& element : header.elements) {
        if (element.name == "vertex") {
            ReadVertices(source, element, context, &mesh->vertices);
        } else if (element.name == "face") {
            ReadFaces(source, element, numVertices, context, mesh);
        } else if (!element.properties.empty()) {
            for (int64_t i = 0; i < element.count; ++i)
                for (const PlyProperty& property : element.properties) SkipProperty(source, property);
        }
    }
}

const PlyElement& RequireElement(const PlyHeader& header, std::string_view name, const PlyContext& context) {
    for (const PlyElement& element : header.elements) {
        if (element.name != name) continue;
        if (element.count > 0 && element.count <= kMaxElements) return element;
        context.FailAtLine(element.line,
                           fmt::format("element \"{}\" has the count {}; a number in [1, {}] is expected",
                                       name, element.count, kMaxElements));
    }
    context.Fail(fmt::format("the header declares no element \"{}\"; a mesh has vertices and faces", name));
}

}  // namespace

PlyMesh ReadPly(const std::string& path, const FileLoc& loc) {
    const PlyContext context(path, loc);
    const FileBytes file = ReadFileBytes(path, loc, {kMaxFileBytes});
    const std::string_view bytes = file.View();
    const PlyHeader header = ParsePlyHeader(bytes, context);
    const int64_t numVertices = RequireElement(header, "vertex", context).count;
    RequireElement(header, "face", context);

    PlyMesh mesh;
    switch (header.format) {
        case PlyHeader::Format::Ascii:
            ReadElements(PlyTextSource(bytes, header, context), header, numVertices, context, &mesh);
            break;
        case PlyHeader::Format::LittleEndian:
            ReadElements(PlyBinarySource<false>(bytes, header, context), header, numVertices, context, &mesh);
            break;
        case PlyHeader::Format::BigEndian:
            ReadElements(PlyBinarySource<true>(bytes, header, context), header, numVertices, context, &mesh);
            break;
    }
    if (mesh.triangles.empty()) mesh.triangles.shrink_to_fit();
    return mesh;
}

}  // namespace lacquer
