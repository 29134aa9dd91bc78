#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pbrt/core/rng.h"
#include "pbrt/shapes/ply_reader.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::test::ply_test {

namespace {

// A folder that goes away with the test.
class TemporaryFolder {
  public:
    TemporaryFolder() {
        std::string name = (std::filesystem::temp_directory_path() / "lacquer-ply-XXXXXX").string();
        if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder");
        path_ = name;
    }
    ~TemporaryFolder() { std::filesystem::remove_all(path_); }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    std::string Write(const std::string& name, const std::string& bytes) const {
        const std::string path = path_ / name;
        std::filesystem::remove(path);  // overwriting makes some file systems wait for the disk
        std::ofstream(path, std::ios::binary) << bytes;
        return path;
    }

  private:
    std::filesystem::path path_;
};

const FileLoc kLoc{"scene.pbrt", 12, 5};

template <class T>
void Put(std::string* out, T value, bool bigEndian) {
    char bytes[sizeof(T)];
    std::memcpy(bytes, &value, sizeof(T));
    if (bigEndian) std::reverse(bytes, bytes + sizeof(T));
    out->append(bytes, sizeof(T));
}

void PutAs(std::string* out, const std::string& type, double value, const std::string& format) {
    if (format == "ascii") {
        *out += fmt::format("{:.9g} ", value);
        return;
    }
    const bool big = format == "binary_big_endian";
    if (type == "char" || type == "int8") Put(out, int8_t(value), big);
    if (type == "uchar" || type == "uint8") Put(out, uint8_t(value), big);
    if (type == "short" || type == "int16") Put(out, int16_t(value), big);
    if (type == "ushort" || type == "uint16") Put(out, uint16_t(value), big);
    if (type == "int" || type == "int32") Put(out, int32_t(value), big);
    if (type == "uint" || type == "uint32") Put(out, uint32_t(value), big);
    if (type == "float" || type == "float32") Put(out, float(value), big);
    if (type == "double" || type == "float64") Put(out, value, big);
}

// A mesh of triangles, quads and one pentagon, with other elements and properties between.
struct TestMesh {
    std::vector<std::array<double, 8>> vertices;
    std::vector<std::vector<int>> faces = {{0, 1, 2}, {2, 1, 3, 4}, {0, 1, 2, 3, 4}, {4, 3, 0}};

    explicit TestMesh(Rng* rng) {
        for (int i = 0; i < 5; ++i) {
            vertices.emplace_back();
            for (double& x : vertices.back()) x = double(float(rng->UniformInt(2001)) - 1000) / 8;
        }
    }
};

template <class T>
void Shuffle(std::vector<T>* items, Rng* rng) {
    for (size_t i = items->size(); i > 1; --i)
        std::swap((*items)[i - 1], (*items)[rng->UniformInt(uint32_t(i))]);
}

std::string Encode(const TestMesh& mesh, const std::string& format, const std::string& lineEnd, Rng* rng) {
    const std::vector<std::string> countTypes = {"char", "uint8", "short", "ushort", "int", "uint32"};
    const std::vector<std::string> valueTypes = {"float", "double", "float32", "float64"};
    const auto pick = [rng](const std::vector<std::string>& types) {
        return types[rng->UniformInt(uint32_t(types.size()))];
    };
    const std::vector<std::array<std::string, 2>> uvNames = {
        {"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
    const auto& uv = uvNames[rng->UniformInt(4)];
    struct Column {
        std::string name, type;
        int channel;  // -1: not used by the mesh, -2: a list not used by the mesh
    };
    std::vector<Column> columns;
    const std::array<std::string, 8> names = {"x", "y", "z", "nx", "ny", "nz", uv[0], uv[1]};
    for (int i = 0; i < 8; ++i) columns.push_back({names[size_t(i)], pick(valueTypes), i});
    columns.push_back({"red", "uchar", -1});
    columns.push_back({"neighbours", "short", -2});
    Shuffle(&columns, rng);
    std::vector<Column> faceColumns = {{"vertex_indices", pick({"int", "uint16", "uchar", "float"}), 0},
                                       {"face_indices", pick({"short", "int", "uchar"}), 1},
                                       {"weights", "double", -2}};
    Shuffle(&faceColumns, rng);
    const std::string countType = pick(countTypes);

    std::string out =
        "ply" + lineEnd + "format " + format + " 1.0" + lineEnd + "comment made by a test" + lineEnd;
    const auto declare = [&](const Column& c, bool list) {
        out += (list ? "property list " + countType + " " : std::string("property ")) + c.type + " " +
               c.name + lineEnd;
    };
    out += "element extra 2" + lineEnd + "property list uchar int stuff" + lineEnd;
    out += fmt::format("element vertex {}{}", mesh.vertices.size(), lineEnd);
    for (const Column& c : columns) declare(c, c.channel == -2);
    out += "obj_info nothing" + lineEnd + fmt::format("element face {}{}", mesh.faces.size(), lineEnd);
    for (const Column& c : faceColumns) declare(c, c.channel != 1);
    out += "end_header" + lineEnd;

    const auto put = [&](const std::string& type, double value) { PutAs(&out, type, value, format); };
    const auto putList = [&](const std::string& count, const std::string& type,
                             const std::vector<double>& items) {
        put(count, double(items.size()));
        for (const double x : items) put(type, x);
    };
    const auto endRow = [&] {
        if (format == "ascii") out += lineEnd;
    };
    for (int i = 0; i < 2; ++i) {
        putList("uchar", "int", {7, 8, 9});
        endRow();
    }
    for (const auto& vertex : mesh.vertices) {
        for (const Column& c : columns) {
            if (c.channel >= 0) put(c.type, vertex[size_t(c.channel)]);
            if (c.channel == -1) put(c.type, 200);
            if (c.channel == -2) putList(countType, c.type, {1, 2});
        }
        endRow();
    }
    for (size_t i = 0; i < mesh.faces.size(); ++i) {
        for (const Column& c : faceColumns) {
            if (c.channel == 0)
                putList(countType, c.type, std::vector<double>(mesh.faces[i].begin(), mesh.faces[i].end()));
            if (c.channel == 1) put(c.type, double(10 + i));
            if (c.channel == -2) putList(countType, c.type, {0.5});
        }
        endRow();
    }
    return out;
}

std::string Gzip(const std::string& bytes) {
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
    std::string out(deflateBound(&stream, bytes.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = uInt(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = uInt(out.size());
    deflate(&stream, Z_FINISH);
    out.resize(stream.total_out);
    deflateEnd(&stream);
    return out;
}

void ExpectEqual(const PlyMesh& ply, const TestMesh& mesh) {
    ASSERT_EQ(ply.vertices.p.size(), mesh.vertices.size());
    ASSERT_EQ(ply.vertices.n.size(), mesh.vertices.size());
    ASSERT_EQ(ply.vertices.uv.size(), mesh.vertices.size());
    for (size_t i = 0; i < mesh.vertices.size(); ++i) {
        const auto& v = mesh.vertices[i];
        EXPECT_EQ(ply.vertices.p[i], Point3(v[0], v[1], v[2]));
        EXPECT_EQ(ply.vertices.n[i], Normal3(v[3], v[4], v[5]));
        EXPECT_EQ(ply.vertices.uv[i], Point2(v[6], v[7]));
    }
    EXPECT_EQ(ply.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {4, 3, 0}}));
    EXPECT_EQ(ply.quads, (std::vector<glm::uvec4>{{2, 1, 3, 4}}));
    EXPECT_EQ(ply.triangleFaceIndices, (std::vector<int>{10, 13}));
    EXPECT_EQ(ply.quadFaceIndices, (std::vector<int>{11}));
    EXPECT_EQ(ply.numIgnoredFaces, 1);
}

class Warnings final : public Observer {
  public:
    void Warn(const std::string& message) override { messages.push_back(message); }
    std::vector<std::string> messages;
};

const std::string kHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

std::string Replace(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace

TEST(Ply, RoundTripInEveryEncodingOrderAndType) {
    const TemporaryFolder folder;
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 60; ++i) {
        const TestMesh mesh(&rng);
        const std::string format =
            std::vector<std::string>{"ascii", "binary_little_endian", "binary_big_endian"}[size_t(i % 3)];
        const std::string lineEnd = i % 2 ? "\n" : "\r\n";
        std::string bytes = Encode(mesh, format, lineEnd, &rng);
        if (i % 5 == 0) bytes = Gzip(bytes);
        SCOPED_TRACE(format + " " + std::to_string(i));
        ExpectEqual(ReadPly(folder.Write("mesh.ply", bytes), kLoc), mesh);
    }
}

TEST(Ply, TextMayLookOdd) {
    const TemporaryFolder folder;
    const std::string body = "+0 1e-50 .5\n\n1. 0\t0 -0.25E+1\r\n1e-400 0 3.0 0 1.0 2";
    const PlyMesh ply = ReadPly(folder.Write("odd.ply", kHeader + body), kLoc);
    EXPECT_EQ(ply.vertices.p[0], Point3(0, 0, 0.5f));
    EXPECT_EQ(ply.vertices.p[2], Point3(-2.5f, 0, 0));
    EXPECT_EQ(ply.triangles[0], glm::uvec3(0, 1, 2));
}

TEST(Ply, QuadsBecomePatchesAroundTheFace) {
    const TemporaryFolder folder;
    const std::string text = Replace(Replace(kHeader, "vertex 3", "vertex 5"), "face 1", "face 3") +
                             "0 0 0  1 0 0  1 1 0  0 1 0  2 0 0\n4 0 1 2 3\n3 1 4 2\n5 0 1 2 3 4\n";
    Warnings warnings;
    const auto shapes = MakeShapes({"plymesh",
                                    {Strings("string", "filename", {folder.Write("quad.ply", text)})},
                                    Transform(),
                                    false,
                                    &warnings});
    ASSERT_EQ(shapes.size(), 2u);
    ASSERT_EQ(warnings.messages.size(), 1u);
    EXPECT_NE(warnings.messages[0].find("1 faces with neither 3 nor 4 corners"), std::string::npos);
    const Ray ray{{0.25f, 0.75f, 1}, {0, 0, -1}};
    const auto hit = shapes[0]->Intersect(ray, 0, 10, 0);
    ASSERT_TRUE(hit);
    SurfaceInteraction si;
    shapes[0]->Interaction(ray, *hit, 0, &si);
    EXPECT_NEAR(si.uv.x, 0.25f, 1e-6f);
    EXPECT_NEAR(si.uv.y, 0.75f, 1e-6f);
    EXPECT_NEAR(si.n.z, 1, 1e-6f);
    EXPECT_NEAR(shapes[1]->Area(0), 0.5f, 1e-6f);
}

// As pbrt-v4: a mesh of polygons is nothing, with a warning.
TEST(Ply, FilesWithoutTrianglesAndQuadsMakeNoShapes) {
    const TemporaryFolder folder;
    const std::string text =
        Replace(kHeader, "vertex 3", "vertex 5") + "0 0 0  1 0 0  1 1 0  0 1 0  2 0 0\n5 0 1 2 3 4\n";
    Warnings warnings;
    EXPECT_TRUE(MakeShapes({"plymesh",
                            {Strings("string", "filename", {folder.Write("pentagon.ply", text)})},
                            Transform(),
                            false,
                            &warnings})
                    .empty());
    ASSERT_EQ(warnings.messages.size(), 1u);
    EXPECT_NE(warnings.messages[0].find("1 faces with neither 3 nor 4 corners"), std::string::npos);
}

// One warning for all; where a corner has a normal it counts, and where none has one, the geometry's does.
TEST(Ply, NormalsAndUvThatAreNotFiniteAreDroppedWithOneWarning) {
    const TemporaryFolder folder;
    const std::string header =
        Replace(Replace(kHeader, "property float z\n",
                        "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                        "property float u\nproperty float v\n"),
                "face 1", "face 2");
    const std::string text = Replace(header, "vertex 3", "vertex 6") +
                             "0 0 0 nan 0 1 0 0\n1 0 0 0 1e99 1 1 0\n0 1 0 -inf 0 0 0 nan\n"
                             "2 0 0 0.6 0 0.8 0 0\n3 0 0 0 nan 1 1 0\n2 1 0 0.6 0 0.8 0 inf\n"
                             "3 0 1 2\n3 3 4 5\n";
    Warnings warnings;
    const auto shapes = MakeShapes({"plymesh",
                                    {Strings("string", "filename", {folder.Write("nan.ply", text)})},
                                    Transform(),
                                    false,
                                    &warnings});
    ASSERT_EQ(shapes.size(), 1u);
    ASSERT_EQ(warnings.messages.size(), 1u);
    EXPECT_NE(warnings.messages[0].find("of 6 vertices, 4 normals and 2 texture coordinates"),
              std::string::npos)
        << warnings.messages[0];
    for (const int face : {0, 1}) {
        const Ray ray{{2 * float(face) + 0.25f, 0.25f, 1}, {0, 0, -1}};
        const auto hit = shapes[0]->Intersect(ray, 0, 10, face);
        ASSERT_TRUE(hit);
        SurfaceInteraction si;
        shapes[0]->Interaction(ray, *hit, face, &si);
        EXPECT_NEAR(Length(si.shading.n - (face ? Normal3(0.6f, 0, 0.8f) : Normal3(0, 0, 1))), 0, 1e-6f);
        EXPECT_TRUE(IsFinite(si.dpdu) && IsFinite(si.dpdv) && IsFinite(si.shading.dpdu));
        EXPECT_TRUE(std::isfinite(si.uv.x) && std::isfinite(si.uv.y));
    }
}

TEST(Ply, MalformedFilesAreNamedWithTheirPlace) {
    const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", good = kHeader + body;
    const std::string binary = Replace(kHeader, "ascii", "binary_little_endian");
    const std::string nanBits("\0\0\xc0\x7f", 4);
    const std::string zeros36(36, '\0');
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "bad.ply:1: \"\" is no PLY header"},
        {"solid cube\n", "bad.ply:1: \"solid cube\" is no PLY header"},
        {"ply\n", "bad.ply:2: the header ends in the middle"},
        {"ply\nformat ascii 1.0\nelement vertex 3\n", "bad.ply:4: the header ends in the middle"},
        {Replace(good, "format ascii 1.0\n", ""), "the header ends without a format"},
        {Replace(good, "ascii", "binary_pdp_endian"), "bad.ply:2: unknown format \"binary_pdp_endian\""},
        {Replace(good, "ascii 1.0", "ascii 2.0"), "bad.ply:2: a malformed format"},
        {Replace(good, "property float x", "property quad x"), "bad.ply:4: unknown type \"quad\""},
        {Replace(good, "property float x", "property float"), "bad.ply:4: a malformed property"},
        {Replace(good, "list uchar int", "list float int"), "bad.ply:8: the count of a list is a float"},
        {Replace(good, "element vertex 3\n", ""), "bad.ply:3: a property before the first element"},
        {Replace(good, "vertex 3", "vertex three"), "bad.ply:3: \"three\" is no count"},
        {Replace(good, "vertex 3", "vertex -3"), "bad.ply:3: \"-3\" is no count"},
        {Replace(good, "vertex 3", "vertex 99999999999999999999"), "is no count"},
        {Replace(good, "vertex 3", "vertex 2147483648"),
         "bad.ply:3: 2147483648 elements \"vertex\" are declared; the file has room for"},
        {Replace(binary, "vertex 3", "vertex 2147483647") + zeros36, "room for 3 at most"},
        {Replace(binary, "face 1", "face 1000000000") + zeros36, "bad.ply:7: 1000000000 elements \"face\""},
        {Replace(good, "element face", "element vertex"), "declared twice"},
        {Replace(good, "element face", "element strip"), "declares no element \"face\""},
        {Replace(good, "element vertex", "element point"), "declares no element \"vertex\""},
        {Replace(good, "face 1", "face 0"), "bad.ply:7: element \"face\" has the count 0"},
        {Replace(good, "vertex 3", "vertex 0"), "bad.ply:3: element \"vertex\" has the count 0"},
        {Replace(good, "float z", "float w"), "properties x, y and z are expected"},
        {Replace(good, "vertex_indices", "corners"), "a list property vertex_indices is expected"},
        {Replace(good, "property float z", "whatever float z"),
         "bad.ply:6: \"whatever\" starts no header line"},
        {Replace(good, "3 0 1 2", "3 0 1 3"), "bad.ply:13: face 0 has the vertex 3; a number in [0, 2]"},
        {Replace(good, "3 0 1 2", "3 0 1 -1"), "the vertex -1"},
        {Replace(good, "3 0 1 2", "3 0 1 1.5"), "bad.ply:13: a fraction"},
        {Replace(good, "3 0 1 2", "3 0 1"), "the data ends too early"},
        {Replace(good, "3 0 1 2", "-3 0 1 2"), "a list of -3 items"},
        {Replace(good, "1 0 0", "1 nan 0"), "bad.ply:11: vertex 1 has a coordinate that is not finite"},
        {Replace(good, "1 0 0", "1 1e60 0"), "bad.ply:11: vertex 1 has a coordinate that is not finite"},
        {Replace(good, "1 0 0", "1 x\x01y 0"), "bad.ply:11: \"x?y\" is no number"},
        {binary + zeros36, "room for 0 at most"},
        {binary + nanBits + zeros36, "vertex 0 has a coordinate that is not finite"},
        {binary + zeros36 + std::string("\3\0\0\0\0\1\0\0\0", 9), "the data ends too early"},
        {binary + zeros36 + std::string("\3\0\0\0\0\1\0\0\0\3\0\0\0", 13),
         "byte 218: face 0 has the vertex 3"},
        {Replace(binary, "list uchar", "list uint") + zeros36 + std::string("\xff\xff\xff\xff", 4),
         "the data ends too early"},
        {Gzip(good).substr(0, 40), "gzip data is damaged"},
        {std::string("\x1f\x8b") + "rubbish", "gzip data is damaged"},
    };
    const TemporaryFolder folder;
    ASSERT_NO_THROW(ReadPly(folder.Write("good.ply", good), kLoc));
    for (const auto& [bytes, expected] : cases) {
        const std::string path = folder.Write("bad.ply", bytes);
        try {
            ReadPly(path, kLoc);
            ADD_FAILURE() << "no error; expected: " << expected;
        } catch (const SceneError& error) {
            EXPECT_EQ(error.Loc().line, kLoc.line);
            EXPECT_NE(std::string(error.what()).find(expected), std::string::npos)
                << error.what() << "\nexpected: " << expected;
        }
    }
}

// Whatever is cut off or changed: an error or a mesh, within the bounds that the sanitizers watch.
TEST(Ply, DamagedFilesNeverCrash) {
    const TemporaryFolder folder;
    Rng rng(SeedOf(FullTestName()));
    int errors = 0;
    for (int i = 0; i < 1500; ++i) {
        const std::string format =
            std::vector<std::string>{"ascii", "binary_little_endian", "binary_big_endian"}[size_t(i % 3)];
        std::string bytes = Encode(TestMesh(&rng), format, "\n", &rng);
        if (rng.Uniform() < 0.3f) bytes.resize(rng.UniformInt(uint32_t(bytes.size())));
        for (int k = int(rng.UniformInt(4)); k >= 0 && !bytes.empty(); --k)
            bytes[rng.UniformInt(uint32_t(bytes.size()))] = char(rng.UniformInt(256));
        try {
            const PlyMesh ply = ReadPly(folder.Write("damaged.ply", bytes), kLoc);
            for (const Point3& p : ply.vertices.p) EXPECT_TRUE(IsFinite(p));
        } catch (const SceneError&) {
            ++errors;
        }
    }
    EXPECT_GT(errors, 300);
}

TEST(Ply, UnreadableFilesAreFileErrors) {
    EXPECT_THROW(ReadPly("/nowhere/at/all.ply", kLoc), FileError);
    EXPECT_THROW(ReadPly("/", kLoc), FileError);
    const std::string error = ErrorOf({"plymesh", {Strings("string", "filename", {"missing.ply"})}});
    EXPECT_NE(error.find("test.pbrt:7:3"), std::string::npos) << error;
    EXPECT_NE(error.find("missing.ply"), std::string::npos) << error;
}

// A grid of a million triangles as 19 MB of binary data. The bound is lenient, for machines with other things
// to do.
TEST(Ply, AMillionTrianglesLoadFastAndSmall) {
    constexpr int kSide = 708;
    std::string bytes = fmt::format(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float "
        "y\nproperty float z\n"
        "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        kSide * kSide, 2 * (kSide - 1) * (kSide - 1));
    bytes.reserve(20000000);
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
            Put(&bytes, float(x), false);
            Put(&bytes, float(y), false);
            Put(&bytes, std::sin(0.1f * float(x) * float(y)), false);
        }
    for (int y = 0; y + 1 < kSide; ++y)
        for (int x = 0; x + 1 < kSide; ++x) {
            const int v = y * kSide + x;
            for (const std::array<int, 3>& face :
                 {std::array{v, v + 1, v + kSide}, std::array{v + 1, v + kSide + 1, v + kSide}}) {
                Put(&bytes, uint8_t(3), false);
                for (const int index : face) Put(&bytes, index, false);
            }
        }
    const TemporaryFolder folder;
    const std::string path = folder.Write("million.ply", bytes);
    const auto start = std::chrono::steady_clock::now();
    const auto shape = MakeShape({"plymesh", {Strings("string", "filename", {path})}, SomeRigidTransform()});
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double rate = double(bytes.size()) / seconds / 1e6;
    const double bytesPerTriangle = double(shape->MemoryBytes()) / shape->NumPrimitives();
    RecordProperty("megabytes_per_second", std::to_string(rate));
    RecordProperty("bytes_per_triangle", std::to_string(bytesPerTriangle));
    EXPECT_GE(rate, 40) << "MB/s";
    EXPECT_LE(bytesPerTriangle, 20);
    EXPECT_GE(shape->NumPrimitives(), 999000);
    EXPECT_EQ(shape->Triangles()->triangles.size(), size_t(shape->NumPrimitives()));
}

}  // namespace lacquer::test::ply_test
