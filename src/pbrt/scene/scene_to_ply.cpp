#include "pbrt/scene/scene_to_ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <vector>

namespace lacquer {

namespace {

static_assert(std::endian::native == std::endian::little, "the files are written as numbers stand in memory");

struct Mesh {
    std::vector<float> p, n, uv;
    std::vector<int> indices, faceIndices;
    size_t NumVertices() const { return p.size() / 3; }
    size_t NumTriangles() const { return indices.size() / 3; }
};

/// The parameters that go into the file; all others stay.
bool IsMeshParameter(const WrittenParameter& p) {
    return p.name == "P" || p.name == "N" || p.name == "uv" || p.name == "S" || p.name == "indices" ||
           p.name == "faceIndices";
}

template <class Number>
bool ReadNumbers(const WrittenParameter& p, NumberProblem (*parse)(std::string_view, Number*),
                 std::vector<Number>* numbers) {
    if (!numbers->empty()) return false;  // given twice
    numbers->reserve(p.values.size());
    for (const WrittenValue& v : p.values) {
        Number number{};
        if (v.isString || parse(v.text, &number) != NumberProblem::None) return false;
        numbers->push_back(number);
    }
    return true;
}

/// True if the counts fit together and all indices are those of vertices.
bool IsSound(const Mesh& mesh) {
    const size_t numVertices = mesh.NumVertices();
    const auto hasOneEach = [&](const std::vector<float>& values, size_t components) {
        return values.empty() || values.size() == components * numVertices;
    };
    return numVertices > 0 && mesh.p.size() % 3 == 0 && hasOneEach(mesh.n, 3) && hasOneEach(mesh.uv, 2) &&
           !mesh.indices.empty() && mesh.indices.size() % 3 == 0 &&
           (mesh.faceIndices.empty() || mesh.faceIndices.size() == mesh.NumTriangles()) &&
           std::all_of(mesh.indices.begin(), mesh.indices.end(),
                       [&](int i) { return i >= 0 && size_t(i) < numVertices; });
}

/// Empty for what is no mesh that a file can hold.
std::optional<Mesh> ReadMesh(const WrittenDirective& shape) {
    Mesh mesh;
    for (const WrittenParameter& p : shape.parameters) {
        bool isGood = !IsMeshParameter(p);
        if (p.type == "point3" && p.name == "P") isGood = ReadNumbers(p, ParseFloat, &mesh.p);
        if (p.type == "normal" && p.name == "N") isGood = ReadNumbers(p, ParseFloat, &mesh.n);
        if (p.type == "point2" && p.name == "uv") isGood = ReadNumbers(p, ParseFloat, &mesh.uv);
        if (p.type == "integer" && p.name == "indices") isGood = ReadNumbers(p, ParseInteger, &mesh.indices);
        if (p.type == "integer" && p.name == "faceIndices")
            isGood = ReadNumbers(p, ParseInteger, &mesh.faceIndices);
        if (!isGood) return std::nullopt;
    }
    // A mesh of one triangle needs no indices.
    if (mesh.indices.empty() && mesh.NumVertices() == 3) mesh.indices = {0, 1, 2};
    return IsSound(mesh) ? std::optional(std::move(mesh)) : std::nullopt;
}

template <class T>
void Append(std::string* bytes, const T* values, size_t count) {
    bytes->append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

std::string PlyBytes(const Mesh& mesh) {
    std::string bytes =
        fmt::format("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", mesh.NumVertices());
    bytes += "property float x\nproperty float y\nproperty float z\n";
    if (!mesh.n.empty()) bytes += "property float nx\nproperty float ny\nproperty float nz\n";
    if (!mesh.uv.empty()) bytes += "property float u\nproperty float v\n";
    bytes += fmt::format("element face {}\nproperty list uchar int vertex_indices\n", mesh.NumTriangles());
    if (!mesh.faceIndices.empty()) bytes += "property int face_indices\n";
    bytes += "end_header\n";
    for (size_t i = 0; i < mesh.NumVertices(); ++i) {
        Append(&bytes, &mesh.p[3 * i], 3);
        if (!mesh.n.empty()) Append(&bytes, &mesh.n[3 * i], 3);
        if (!mesh.uv.empty()) Append(&bytes, &mesh.uv[2 * i], 2);
    }
    for (size_t i = 0; i < mesh.NumTriangles(); ++i) {
        bytes += char(3);
        Append(&bytes, &mesh.indices[3 * i], 3);
        if (!mesh.faceIndices.empty()) Append(&bytes, &mesh.faceIndices[i], 1);
    }
    return bytes;
}

/// Takes the mesh's parameters out, with their comments, and names the file instead.
void ReplaceMesh(WrittenDirective* shape, const std::string& filename, SceneText* scene) {
    WrittenParameter file{"string", "filename", {{scene->Own(filename), true}}, shape->loc, {}, {}};
    std::vector<WrittenParameter> kept;
    for (WrittenParameter& p : shape->parameters) {
        if (!IsMeshParameter(p)) {
            kept.push_back(std::move(p));
            continue;
        }
        file.commentsBefore.insert(file.commentsBefore.end(), p.commentsBefore.begin(),
                                   p.commentsBefore.end());
        if (!p.commentBehind.empty()) file.commentsBefore.push_back(p.commentBehind);
    }
    kept.insert(kept.begin(), std::move(file));
    shape->parameters = std::move(kept);
    shape->arguments[0].text = "plymesh";
}

}  // namespace

int MoveMeshesToPly(SceneText* scene, int64_t minTriangles,
                    const std::function<std::string(const std::string& bytes)>& store) {
    int count = 0;
    for (WrittenDirective& directive : scene->directives) {
        if (directive.name != "Shape" || directive.arguments[0].text != "trianglemesh") continue;
        const std::optional<Mesh> mesh = ReadMesh(directive);
        if (!mesh || int64_t(mesh->NumTriangles()) < minTriangles) continue;
        ReplaceMesh(&directive, store(PlyBytes(*mesh)), scene);
        ++count;
    }
    return count;
}

}  // namespace lacquer
