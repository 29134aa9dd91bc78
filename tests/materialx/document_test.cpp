#include "materialx/document.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::materialx::document_test {
namespace {

namespace fs = std::filesystem;

class MaterialX : public testing::Test {
  protected:
    MaterialX() : folder_(fs::temp_directory_path() / fmt::format("materialx-{}", getpid())) {
        fs::create_directories(folder_);
    }
    ~MaterialX() override { fs::remove_all(folder_); }

    MaterialText Read(const std::string& body, const std::string& attributes = "") {
        const fs::path path = folder_ / "a.mtlx";
        std::ofstream(path) << "<?xml version=\"1.0\"?>\n<materialx version=\"1.39\"" << attributes << ">\n"
                            << body << "\n</materialx>\n";
        return ReadDocument(path.string());
    }
    std::string ErrorOf(const std::string& body) {
        try {
            Read(body);
        } catch (const SceneError& e) {
            return e.Loc().ToString() + ": " + e.Message();
        }
        return "no error";
    }
    /// The materials are such that a scene can have them.
    static void ExpectIsRead(const MaterialText& m) {
        for (const std::string& name : m.materials)
            EXPECT_NO_THROW(
                BuildMaterial(ParseText("WorldBegin\n" + m.text, "m.pbrt", "", nullptr), name, {}, nullptr))
                << m.text;
    }
    static bool Has(const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    }

    fs::path folder_;
};

constexpr const char* kRed = R"(
  <open_pbr_surface name="S" type="surfaceshader">
    <input name="base_color" type="color3" value="0.6, 0.05, 0.02" />
    <input name="coat_weight" type="float" value="1" />
    <input name="geometry_thin_walled" type="boolean" value="true" />
  </open_pbr_surface>
  <surfacematerial name="Red paint" type="material">
    <input name="surfaceshader" type="surfaceshader" nodename="S" />
  </surfacematerial>)";

TEST_F(MaterialX, ValuesBecomeParameters) {
    const MaterialText m = Read(kRed);
    EXPECT_EQ(m.materials, std::vector<std::string>{"Red paint"});
    EXPECT_TRUE(m.warnings.empty());
    EXPECT_TRUE(Has(m.text, "MakeNamedMaterial \"Red paint\" \"string type\" \"openpbr\"")) << m.text;
    EXPECT_TRUE(Has(m.text, "\"rgb base_color\" [0.6 0.05 0.02]")) << m.text;
    EXPECT_TRUE(Has(m.text, "\"float coat_weight\" 1")) << m.text;
    EXPECT_TRUE(Has(m.text, "\"bool geometry_thin_walled\" true")) << m.text;
    ExpectIsRead(m);
}

TEST_F(MaterialX, StandardSurfacesHaveTheirOwnNamesAndDefaults) {
    const MaterialText m = Read(R"(<standard_surface name="S" type="surfaceshader">
      <input name="metalness" type="float" value="1" />
      <input name="specular_rotation" type="float" value="0.25" />
      <input name="thin_film_thickness" type="float" value="400" />
      <input name="opacity" type="color3" value="0.5, 0.5, 0.5" /></standard_surface>)");
    EXPECT_EQ(m.materials, std::vector<std::string>{"S"});
    for (const char* part :
         {"\"float base_metalness\" 1", "\"float rotation\" 90",
          "\"float thin_film_thickness\" 0.4 \"float thin_film_weight\" 1", "\"float geometry_opacity\" 0.5",
          "\"float specular_roughness\" 0.2", "\"float coat_ior\" 1.5"})
        EXPECT_TRUE(Has(m.text, part)) << part << '\n' << m.text;
    ExpectIsRead(m);
}

TEST_F(MaterialX, EmissionAndTheCoatsFrame) {
    const MaterialText m =
        Read(R"(<image name="I" type="vector3"><input name="file" type="filename" value="n.png" /></image>
      <normalmap name="N" type="vector3"><input name="in" type="vector3" nodename="I" /></normalmap>
      <open_pbr_surface name="S" type="surfaceshader">
        <input name="emission_luminance" type="float" value="200" />
        <input name="emission_color" type="color3" value="1, 0.5, 0.25" />
        <input name="geometry_coat_normal" type="vector3" nodename="N" /></open_pbr_surface>
      <standard_surface name="T" type="surfaceshader">
        <input name="emission" type="float" value="3" /><input name="coat_rotation" type="float" value="0.5" />
        <input name="coat_normal" type="vector3" nodename="N" /></standard_surface>)");
    EXPECT_TRUE(m.warnings.empty());
    for (const char* part :
         {"\"float emission_luminance\" 200", "\"rgb emission_color\" [1 0.5 0.25]",
          "\"string coat_normalmap\"", "\"float emission_luminance\" 3", "\"float coat_rotation\" 180"})
        EXPECT_TRUE(Has(m.text, part)) << part << '\n' << m.text;
}

TEST_F(MaterialX, ImagesOfNodeGraphs) {
    const MaterialText m = Read(R"(<nodegraph name="NG">
        <input name="photo" type="filename" value="wood.png" colorspace="srgb_texture" />
        <tiledimage name="I" type="color3"><input name="file" type="filename" interfacename="photo" />
          <input name="uvtiling" type="vector2" value="4, 2" /></tiledimage>
        <constant name="C" type="color3"><input name="value" type="color3" value="0.5, 1, 1" /></constant>
        <multiply name="M" type="color3"><input name="in1" nodename="C" type="color3" /><input name="in2" nodename="I" type="color3" /></multiply>
        <output name="out" type="color3" nodename="M" /></nodegraph>
      <image name="R" type="float"><input name="file" type="filename" value="rough.exr" /></image>
      <open_pbr_surface name="S" type="surfaceshader">
        <input name="base_color" type="color3" nodegraph="NG" output="out" />
        <input name="specular_roughness" type="float" nodename="R" /></open_pbr_surface>)");
    EXPECT_TRUE(m.warnings.empty());
    for (const char* part : {"wood.png\" \"string encoding\" \"sRGB\" \"float uscale\" 4 \"float vscale\" 2",
                             "\"rgb scale\" [0.5 1 1]", "\"texture base_color\" \"S: base_color\"",
                             "rough.exr\" \"string encoding\" \"linear\"",
                             "\"texture specular_roughness\" \"S: specular_roughness\""})
        EXPECT_TRUE(Has(m.text, part)) << part << '\n' << m.text;
    EXPECT_TRUE(Has(m.text, (folder_ / "wood.png").string()));
}

TEST_F(MaterialX, WhatIsNotUnderstoodIsNamed) {
    const MaterialText m = Read(R"(<fractal3d name="F" type="color3" />
<open_pbr_surface name="S" type="surfaceshader">
  <input name="base_color" type="color3" nodename="F" />
  <input name="subsurface_radius" type="float" value="2" />
  <input name="bsae_weight" type="float" value="2" />
</open_pbr_surface>)");
    ASSERT_EQ(m.warnings.size(), 3u);
    std::string all;
    for (const Diagnostic& w : m.warnings) all += w.ToString() + "\n";
    EXPECT_TRUE(Has(all, "a.mtlx:3:") && Has(all, "fractal3d") &&
                Has(all, "\"base_color\" keeps its default"))
        << all;
    EXPECT_TRUE(Has(all, "subsurface_radius") && Has(all, "bsae_weight")) << all;
    ExpectIsRead(m);
}

TEST_F(MaterialX, RefusesWhatIsNoDocument) {
    EXPECT_TRUE(Has(ErrorOf("<open_pbr_surface name=\"S\""), "is no XML"))
        << ErrorOf("<open_pbr_surface name=\"S\"");
    EXPECT_TRUE(Has(ErrorOf(""), "no surface that is understood"));
    EXPECT_TRUE(Has(ErrorOf("<surfacematerial name=\"M\"/>"), "a.mtlx:3:"));
    const auto surface = [](const std::string& inputs) {
        return "<open_pbr_surface name=\"S\">" + inputs + "</open_pbr_surface>";
    };
    EXPECT_TRUE(Has(ErrorOf(surface("<input name=\"base_color\" nodename=\"none\"/>")), "no node \"none\""));
    EXPECT_TRUE(
        Has(ErrorOf(surface("<input name=\"base_color\" nodegraph=\"none\"/>")), "no node graph \"none\""));
    EXPECT_TRUE(Has(ErrorOf(surface("<input name=\"base_color\" value=\"1, 2\"/>")), "three numbers"));
    EXPECT_TRUE(Has(ErrorOf(surface("<input name=\"base_weight\" value=\"much\"/>")), "expected a number"));
    // Nodes in a circle.
    EXPECT_TRUE(Has(ErrorOf("<dot name=\"A\"><input name=\"in\" nodename=\"B\"/></dot><dot name=\"B\"><input "
                            "name=\"in\" nodename=\"A\"/></dot>" +
                            surface("<input name=\"base_weight\" nodename=\"A\"/>")),
                    "circle"));
    EXPECT_THROW(ReadDocument((folder_ / "none.mtlx").string()), FileError);
}

// Names that would end a text of the scene format.
TEST_F(MaterialX, NamesCannotAddDirectives) {
    const MaterialText m = Read(
        "<open_pbr_surface name=\"a&quot; Shape &quot;sphere\\\"><input name=\"base_weight\" "
        "value=\"1\"/></open_pbr_surface>");
    const SceneDescription scene = ParseText("WorldBegin\n" + m.text, "m.pbrt", "", nullptr);
    EXPECT_TRUE(scene.shapes.empty());
    ASSERT_EQ(scene.namedMaterials.size(), 1u);
    EXPECT_EQ(scene.namedMaterials[0].name, "a\" Shape \"sphere\\");
}

}  // namespace
}  // namespace lacquer::materialx::document_test
