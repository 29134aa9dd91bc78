// What the materials read, what they make of it, and what they refuse.
#include <gtest/gtest.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/scattering/thin_film.h"

namespace lacquer::materials_test {
namespace {

/// A library with one named texture of each kind.
class TestTextures final : public TextureLibrary {
  public:
    const FloatTexture* Float(const std::string&, const FileLoc&) override { return &varying_; }
    const SpectrumTexture* Spectrum(const std::string&, SpectrumKind, const FileLoc&) override {
        return &varyingSpectrum_;
    }
    const FloatTexture* Own(std::unique_ptr<FloatTexture> t) override {
        return floats_.emplace_back(std::move(t)).get();
    }
    const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> t) override {
        return spectra_.emplace_back(std::move(t)).get();
    }
    ImageCache& Images() override { throw std::logic_error("no image is read here"); }

  private:
    /// The u coordinate.
    class VaryingFloat final : public FloatTexture {
        float Evaluate(const TextureContext& context) const override { return context.uv.x; }
    };
    class VaryingSpectrum final : public SpectrumTexture {
        SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths&) const override {
            return SampledSpectrum(context.uv.x);
        }
    };
    VaryingFloat varying_;
    VaryingSpectrum varyingSpectrum_;
    std::vector<std::unique_ptr<FloatTexture>> floats_;
    std::vector<std::unique_ptr<SpectrumTexture>> spectra_;
};

Parameter Named(const char* type, const char* name, Parameter::Values kind) {
    Parameter p;
    p.type = type;
    p.name = name;
    p.loc = {"scene.pbrt", 7, 3};
    p.kind = kind;
    p.colorSpace = &ColorSpace::SRGB();
    return p;
}
Parameter Floats(const char* type, const char* name, std::vector<float> values) {
    Parameter p = Named(type, name, Parameter::Values::Floats);
    p.floats = std::move(values);
    return p;
}
Parameter Strings(const char* type, const char* name, std::vector<std::string> values) {
    Parameter p = Named(type, name, Parameter::Values::Strings);
    p.strings = std::move(values);
    return p;
}
Parameter Bool(const char* name, bool value) {
    Parameter p = Named("bool", name, Parameter::Values::Bools);
    p.bools = {value};
    return p;
}

class Materials : public testing::Test {
  protected:
    /// Makes a material; every parameter must have been understood.
    std::unique_ptr<Material> Make(const std::string& name, std::vector<Parameter> parameters = {}) {
        const Params params("material \"" + name + "\"", {"scene.pbrt", 7, 1}, std::move(parameters),
                            &ColorSpace::SRGB());
        const auto factory = Registry<MaterialKind>::Find(name);
        if (!factory) throw std::logic_error("not registered: " + name);
        auto material = factory({params, textures_, named_});
        params.CheckAllUsed();
        return material;
    }
    std::string ErrorOf(const std::string& name, std::vector<Parameter> parameters) {
        try {
            Make(name, std::move(parameters));
        } catch (const SceneError& e) {
            EXPECT_EQ(e.Loc().line, 7);
            return e.Message();
        } catch (const SceneErrors& e) {
            return e.what();
        }
        return "no error";
    }
    const BxDF* BxDFOf(const Material& material, float u = 0.3f) {
        TextureContext context;
        context.uv = {u, 0};
        lambda_ = SampledWavelengths::SampleVisible(0.4f);
        return material.MakeBxDF(context, lambda_, arena_);
    }
    /// Value in the mirror direction at 45 degrees; alpha follows from it.
    static SampledSpectrum Mirror(const BxDF& bxdf) {
        const float c = std::sqrt(0.5f);
        return bxdf.Evaluate({c, 0, c}, {-c, 0, c}, {}).f;
    }

    TestTextures textures_;
    std::map<std::string, const Material*> named_;
    SampledWavelengths lambda_;
    Arena arena_;
};

TEST_F(Materials, DiffuseDefaultsToHalfAndClamps) {
    const auto grey = Make("diffuse");
    EXPECT_FLOAT_EQ(Mirror(*BxDFOf(*grey))[0], 0.5f * InvPi);
    EXPECT_FALSE(grey->NeedsFootprint());
    const auto textured = Make("diffuse", {Strings("texture", "reflectance", {"t"})});
    EXPECT_TRUE(textured->NeedsFootprint());
    EXPECT_FLOAT_EQ(Mirror(*BxDFOf(*textured, 7))[0], InvPi);
    EXPECT_EQ(BxDFOf(*textured, NAN)->Flags(), Lobes::None);
}

TEST_F(Materials, DiffuseTransmissionScalesThenClamps) {
    const auto sheet = Make("diffusetransmission", {Floats("float", "scale", {3})});
    EXPECT_FLOAT_EQ(Mirror(*BxDFOf(*sheet))[0], 0.75f * InvPi);
    const auto bright = Make("diffusetransmission", {Floats("float", "scale", {30})});
    EXPECT_FLOAT_EQ(Mirror(*BxDFOf(*bright))[0], InvPi);
}

TEST_F(Materials, ConductorIsSmoothCopperByDefault) {
    const auto copper = Make("conductor");
    const BxDF* bxdf = BxDFOf(*copper);
    EXPECT_EQ(bxdf->Flags(), Lobes::SpecularReflection);
    const auto sample = bxdf->Sample({0, 0, 1}, {}, {});
    ASSERT_TRUE(sample);
    // Red copper: the longest of the path's wavelengths is reflected more than the shortest.
    int longest = 0, shortest = 0;
    for (int i = 1; i < kNumWavelengths; ++i) {
        if (lambda_[i] > lambda_[longest]) longest = i;
        if (lambda_[i] < lambda_[shortest]) shortest = i;
    }
    EXPECT_GT(sample->weight[longest], 0.9f);
    EXPECT_LT(sample->weight[shortest], 0.65f);
    EXPECT_FALSE(lambda_.SecondaryTerminated());
}

TEST_F(Materials, ConductorTakesAReflectanceInstead) {
    const auto metal = Make("conductor", {Floats("rgb", "reflectance", {0.8f, 0.8f, 0.8f})});
    EXPECT_NEAR(BxDFOf(*metal)->Sample({0, 0, 1}, {}, {})->weight[0], 0.8f, 2e-3f);
    // A reflectance of 1 is held below, which keeps k finite.
    const auto mirror = Make("conductor", {Floats("rgb", "reflectance", {1, 1, 1})});
    EXPECT_NEAR(BxDFOf(*mirror)->Sample({0, 0, 1}, {}, {})->weight[0], 0.9999f, 1e-5f);
    EXPECT_NE(ErrorOf("conductor", {Floats("rgb", "reflectance", {1, 1, 1}), Floats("rgb", "k", {1, 1, 1})})
                  .find("only one"),
              std::string::npos);
}

TEST_F(Materials, RoughnessIsRemappedBySquareRoot) {
    const auto reflectance = Floats("rgb", "reflectance", {0.8f, 0.8f, 0.8f});
    const auto remapped = Make("conductor", {reflectance, Floats("float", "roughness", {0.16f})});
    const auto direct =
        Make("conductor", {reflectance, Floats("float", "roughness", {0.4f}), Bool("remaproughness", false)});
    EXPECT_NEAR(Mirror(*BxDFOf(*remapped))[0], Mirror(*BxDFOf(*direct))[0], 1e-5f);
    const auto perAxis = Make("conductor", {reflectance, Floats("float", "uroughness", {0.16f}),
                                            Floats("float", "vroughness", {0.16f})});
    EXPECT_EQ(Mirror(*BxDFOf(*perAxis)), Mirror(*BxDFOf(*remapped)));
    // Without effect beside both axes, roughness is left over.
    EXPECT_NE(
        ErrorOf("conductor", {Floats("float", "uroughness", {0.1f}), Floats("float", "vroughness", {0.1f}),
                              Floats("float", "roughness", {0.1f})})
            .find("roughness"),
        std::string::npos);
    // Wherever the texture is below the threshold the boundary is smooth.
    const auto textured = Make("conductor", {Strings("texture", "roughness", {"t"})});
    EXPECT_TRUE(textured->NeedsFootprint());
    EXPECT_TRUE(IsSpecular(BxDFOf(*textured, 0)->Flags()));
    EXPECT_TRUE(IsSpecular(BxDFOf(*textured, NAN)->Flags()));
    EXPECT_FALSE(IsSpecular(BxDFOf(*textured, 0.5f)->Flags()));
}

TEST_F(Materials, DistributionIsChosenByName) {
    const auto rough = Floats("float", "roughness", {0.25f});
    const auto ggx = Make("dielectric", {rough}),
               named = Make("dielectric", {rough, Strings("string", "distribution", {"trowbridgereitz"})});
    const auto beckmann = Make("dielectric", {rough, Strings("string", "distribution", {"beckmann"})});
    EXPECT_EQ(Mirror(*BxDFOf(*ggx)), Mirror(*BxDFOf(*named)));
    EXPECT_NE(Mirror(*BxDFOf(*ggx))[0], Mirror(*BxDFOf(*beckmann))[0]);
    EXPECT_NE(ErrorOf("dielectric", {rough, Strings("string", "distribution", {"bekmann"})}).find("beckmann"),
              std::string::npos);
}

// Where it is off, or where nothing is rough, the boundaries are the ones that product estimators know.
TEST_F(Materials, MultiscatterIsForRoughBoundariesThatAskForIt) {
    const auto isSingle = [&](const char* name, float roughness, std::optional<bool> multiscatter) {
        std::vector<Parameter> parameters = {Floats("float", "roughness", {roughness})};
        if (multiscatter) parameters.push_back(Bool("multiscatter", *multiscatter));
        return std::holds_alternative<MicrofacetSurface>(BxDFOf(*Make(name, parameters))->Model());
    };
    const auto isSmooth = [&](const char* name) {
        return IsSpecular(BxDFOf(*Make(name, {Bool("multiscatter", true)}))->Flags());
    };
    for (const char* name : {"conductor", "dielectric"}) {
        EXPECT_TRUE(isSingle(name, 0.4f, std::nullopt));
        EXPECT_TRUE(isSingle(name, 0.4f, false));
        EXPECT_FALSE(isSingle(name, 0.4f, true));
        EXPECT_TRUE(isSmooth(name));
    }
}

TEST_F(Materials, AVaryingIndexEndsSecondaryWavelengths) {
    const auto eta = [&](const Material& m) {
        return BxDFOf(m)->Sample({0, 0, 1}, {.lobe = OneMinusEpsilon}, {})->eta;
    };
    EXPECT_FLOAT_EQ(eta(*Make("dielectric")), 1.5f);
    EXPECT_FALSE(lambda_.SecondaryTerminated());
    EXPECT_FLOAT_EQ(eta(*Make("dielectric", {Floats("float", "eta", {1.33f})})), 1.33f);
    EXPECT_FALSE(lambda_.SecondaryTerminated());
    EXPECT_FLOAT_EQ(eta(*Make("dielectric", {Floats("spectrum", "eta", {300, 1.2f, 900, 1.2f})})), 1.2f);
    EXPECT_TRUE(lambda_.SecondaryTerminated());
    const auto thin = Make("thindielectric", {Floats("spectrum", "eta", {300, 1.2f, 900, 1.2f})});
    BxDFOf(*thin);
    EXPECT_TRUE(lambda_.SecondaryTerminated());
    // Outside of its samples a spectrum is 0, which counts as 1.
    EXPECT_EQ(eta(*Make("dielectric", {Floats("spectrum", "eta", {200, 1.2f, 300, 1.2f})})), 1);
    EXPECT_NE(ErrorOf("dielectric", {Floats("float", "eta", {-1})}).find("positive"), std::string::npos);
    EXPECT_NE(ErrorOf("dielectric", {Floats("float", "eta", {NAN})}).find("finite"), std::string::npos);
    EXPECT_EQ(eta(*Make("dielectric", {Floats("float", "eta", {1e30f})})), 1e3f);
}

TEST_F(Materials, MixDrawsTheSecondWithItsAmount) {
    const auto a = Make("diffuse"), b = Make("dielectric");
    named_ = {{"a", a.get()}, {"b", b.get()}};
    const auto share = [&](const Material& mix) {
        int second = 0;
        Rng rng(3);
        for (int i = 0; i < 20000; ++i) {
            TextureContext context;
            context.p = {rng.Uniform(), rng.Uniform(), rng.Uniform()};
            const Material* chosen = mix.Choose(context, {0, 0, 1});
            EXPECT_EQ(chosen, mix.Choose(context, {0, 0, 1})) << "one hit, one answer";
            second += chosen == b.get();
        }
        return second / 20000.;
    };
    const auto names = Strings("string", "materials", {"a", "b"});
    const auto mixOf = [&](float amount) {
        return Make("mix", {names, Floats("float", "amount", {amount})});
    };
    EXPECT_EQ(share(*mixOf(0)), 0);
    EXPECT_EQ(share(*mixOf(1)), 1);
    // Standard error below 0.0036, 5 sigma.
    EXPECT_NEAR(share(*mixOf(0.3f)), 0.3, 0.018);
    const auto half = Make("mix", {names});
    EXPECT_NEAR(share(*half), 0.5, 0.018);
    EXPECT_FALSE(half->NeedsFootprint());
    // The draws of a mix within a mix are independent of those outside: 0.5 * 0.5.
    named_["half"] = half.get();
    EXPECT_NEAR(share(*Make("mix", {Strings("string", "materials", {"a", "half"})})), 0.25, 0.018);
}

TEST_F(Materials, MixSaysWhatIsWrongWithItsNames) {
    const auto a = Make("diffuse"), none = Make("interface");
    named_ = {{"marble", a.get()}, {"none", none.get()}};
    EXPECT_NE(ErrorOf("mix", {Strings("string", "materials", {"marble", "marbel"})}).find("\"marble\"?"),
              std::string::npos);
    EXPECT_NE(ErrorOf("mix", {Strings("string", "materials", {"marble", "none"})}).find("interface"),
              std::string::npos);
    EXPECT_NE(ErrorOf("mix", {Strings("string", "materials", {"marble"})}).find("two"), std::string::npos);
    EXPECT_NE(ErrorOf("mix", {}).find("two"), std::string::npos);
}

TEST_F(Materials, InterfaceScattersNothingAndChecksNothing) {
    const auto surface = Make("interface", {Floats("float", "whatever", {1})});
    EXPECT_TRUE(surface->IsInvisible());
    EXPECT_FALSE(surface->NeedsFootprint());
    EXPECT_EQ(BxDFOf(*surface), nullptr);
}

TEST_F(Materials, UnknownParametersAreReported) {
    for (const char* name : {"diffuse", "conductor", "dielectric", "thindielectric", "diffusetransmission"})
        EXPECT_NE(ErrorOf(name, {Floats("float", "kd", {1})}), "no error") << name;
    // The boundary of thin glass is always smooth.
    EXPECT_NE(ErrorOf("thindielectric", {Floats("float", "roughness", {1})}), "no error");
}

// ---- Thin films
// ----------------------------------------------------------------------------------------------

TEST_F(Materials, FilmsReflectWhatTheyAreGiven) {
    const auto soap =
        Make("dielectric", {Floats("float", "eta", {1}), Floats("float", "thinfilm_thickness", {250}),
                            Floats("float", "thinfilm_eta", {1.33f})});
    const BxDF* bxdf = BxDFOf(*soap);
    EXPECT_EQ(bxdf->Flags(), Lobes::BothSides | Lobes::Specular);
    const ThinFilm film(250, SampledSpectrum(1.33f), SampledSpectrum(0), lambda_.Lambda(), 1);
    const ThinFilm::Shares shares = film.OnDielectric(1, 1);
    const auto sample = bxdf->Sample({0, 0, 1}, {}, {});
    ASSERT_TRUE(sample && sample->IsReflection());
    for (int i = 0; i < kNumWavelengths; ++i)
        EXPECT_NEAR(sample->weight[i] * sample->pdf, shares.reflected[i], 1e-6f);

    const auto oxide = Make(
        "conductor", {Floats("float", "thinfilm_thickness", {60}), Floats("float", "thinfilm_k", {0.1f})});
    const auto bare = Make("conductor");
    EXPECT_FALSE(BxDFOf(*oxide)->Sample({0, 0, 1}, {}, {})->weight ==
                 BxDFOf(*bare)->Sample({0, 0, 1}, {}, {})->weight);
}

TEST_F(Materials, FilmsOfNoThicknessAreNotThere) {
    const auto textured = Make("dielectric", {Strings("texture", "thinfilm_thickness", {"t"})});
    EXPECT_TRUE(textured->NeedsFootprint());
    const auto bare = Make("dielectric");
    EXPECT_FALSE(bare->NeedsFootprint());
    const auto weight = [&](const Material& material, float u) {
        return BxDFOf(material, u)->Sample({0, 0, 1}, {}, {})->weight;
    };
    // The texture is u in nanometers.
    for (const float u : {0.f, -5.f, float(NAN)}) EXPECT_EQ(weight(*textured, u), weight(*bare, 0)) << u;
    EXPECT_TRUE(weight(*textured, 1e30f).IsValid());
}

TEST_F(Materials, FilmsAreRelativeToTheMediumAbove) {
    const auto metal = Make(
        "conductor", {Floats("float", "thinfilm_thickness", {90}), Floats("float", "thinfilm_eta", {2})});
    SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.4f);
    const auto* boundary = dynamic_cast<const StackBoundary*>(metal.get());
    ASSERT_NE(boundary, nullptr);
    const BxDF* under = boundary->MakeBoundary({}, lambda, arena_, {1.5f, {}});
    const SampledSpectrum eta = NamedSpectrum("metal-Cu-eta")->Sample(lambda),
                          k = NamedSpectrum("metal-Cu-k")->Sample(lambda);
    const ThinFilm film(90, SampledSpectrum(2), SampledSpectrum(0), lambda.Lambda(), 1.5f);
    const SampledSpectrum expected = film.OnConductor(1, eta / 1.5f, k / 1.5f);
    const SampledSpectrum weight = under->Sample({0, 0, 1}, {}, {})->weight;
    for (int i = 0; i < kNumWavelengths; ++i) EXPECT_NEAR(weight[i], expected[i], 1e-6f);
}

TEST_F(Materials, FilmsRefuseNonsense) {
    const auto errorOf = [&](const char* name, float value) {
        return ErrorOf("dielectric",
                       {Floats("float", "thinfilm_thickness", {100}), Floats("float", name, {value})});
    };
    EXPECT_NE(errorOf("thinfilm_eta", 0).find("expected a positive number"), std::string::npos);
    EXPECT_NE(errorOf("thinfilm_k", -1).find("expected a number that is not negative"), std::string::npos);
    EXPECT_NE(ErrorOf("conductor", {Floats("float", "thinfilm_thickness", {-1})}).find("from 0 to 100000"),
              std::string::npos);
    EXPECT_NE(ErrorOf("conductor", {Floats("float", "thinfilm_eta", {1.5f})}).find("thinfilm_thickness"),
              std::string::npos);
    EXPECT_NE(ErrorOf("dielectric", {Floats("float", "thinfilm_thickness", {9}), Bool("multiscatter", true)})
                  .find("only one"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::materials_test
