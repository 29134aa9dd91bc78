// What src/denoise/oidn.cpp asks of Open Image Denoise, by a double of the library; without one, that it says
// so. Not in the unit tests: those are built with whatever library there is.
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <tuple>

#include "denoise/oidn.h"

#if LACQUER_HAS_OIDN
#include <OpenImageDenoise/oidn.hpp>
#endif

namespace lacquer::denoise {
namespace {

int passed = 0, failed = 0;

void Expect(bool is, const std::string& what) {
    ++(is ? passed : failed);
    if (!is) std::printf("FAILED: %s\n", what.c_str());
}

constexpr Int2 kSize(5, 3);
constexpr int kThreads = 3;

/// Another value in each pixel, channel and image.
Color Values(float first) {
    Color image(kSize);
    for (auto& value : image.All())
        for (float& x : value) x = first += 0.25f;
    return image;
}

struct Heard final : Observer {
    int64_t total = 0, done = 0;
    bool ended = false;
    void Begin(const std::string&, int64_t units, const std::string&) override { total = units; }
    void Advance(int64_t units) override { done += units; }
    void End() override { ended = true; }
};

std::string WhyFailed(const Color& color, const Color& albedo, const Color& normal) {
    try {
        FilterByOidn(color, albedo, normal, kThreads, nullptr);
    } catch (const std::runtime_error& e) {
        return e.what();
    }
    return {};
}

#if LACQUER_HAS_OIDN

using oidn::state;

void PixelsArriveAndReturn() {
    const Color color = Values(0), albedo = Values(100), normal = Values(-50);
    Heard heard;
    const Color result = FilterByOidn(color, albedo, normal, kThreads, &heard);
    float worst = 0;
    for (size_t i = 0; i < result.All().size(); ++i)
        for (size_t c = 0; c < 3; ++c) {
            // By the double: guides are halved by their own filters.
            const float expected = 2 * color.All()[i][c] + 0.5f * albedo.All()[i][c] + 5 * normal.All()[i][c];
            worst = std::max(worst, std::abs(result.All()[i][c] - expected));
        }
    Expect(result.Size() == kSize && worst < 1e-3f, "every pixel is filtered, with its own guides");
    Expect(heard.total == 3 * 15 && heard.done == heard.total && heard.ended, "progress reaches its end");
}

void ParametersAreThoseOfTheDocumentation() {
    Expect(state.type == oidn::DeviceType::CPU && state.numThreads == kThreads, "processors, and how many");
    Expect(state.executions.size() == 3, "three filters");
    if (state.executions.size() != 3) return;
    const auto& [first, second, last] =
        std::tie(state.executions[0], state.executions[1], state.executions[2]);
    Expect(first.images.count("albedo") && !first.images.count("color") && first.flags.empty(),
           "the albedo by itself");
    Expect(second.images.count("normal") && !second.images.count("color") && second.flags.empty(),
           "the normal by itself");
    Expect(last.images.size() == 4 && last.flags.size() == 2 && last.flags.at("hdr") &&
               last.flags.at("cleanAux"),
           "colours with both guides, hdr, cleanAux");
    const oidn::ImageParameter& color = last.images.at("color");
    Expect(color.format == oidn::Format::Float3 && color.width == 5 && color.height == 3 &&
               color.pixelStride == 12 && color.rowStride == 60,
           "three packed floats in rows");
    Expect(last.images.at("albedo").data == first.images.at("output").data &&
               last.images.at("normal").data == second.images.at("output").data,
           "guides are the filtered ones");
    Expect(last.images.at("output").data != color.data, "colours stay as they are");
}

void FailuresAreMessages() {
    const Color image = Values(1);
    for (const char* where : {"newDevice", "commitDevice", "newFilter", "commitFilter", "execute"}) {
        state = {};
        state.failAt = where;
        Expect(WhyFailed(image, image, image) == "Open Image Denoise: the reason", where);
        Expect(state.alive == 0, std::string(where) + ": nothing is left");
    }
    state = {};
    state.failAt = "execute";
    state.message = "";
    Expect(WhyFailed(image, image, image) == "Open Image Denoise: failed without a reason", "no reason");
    state = {};
    state.hasNoDevice = true;
    Expect(WhyFailed(image, image, image) == "Open Image Denoise: there is no device for processors",
           "no device");
    state = {};
    Expect(WhyFailed(image, Color(Int2(4, 3)), image).find("sizes differ") != std::string::npos,
           "what the library refuses");
    state = {};
    Expect(WhyFailed(image, image, image).empty() && state.alive == 0, "and after that it works");
}

/// The double notices what it is there to notice.
void TheDoubleIsStrict() {
    state = {};
    oidn::DeviceRef device = oidn::newDevice();
    const char* message = nullptr;
    device.newFilter("RT");
    Expect(device.getError(message) == oidn::Error::InvalidOperation, "a device that is not committed");
    device.commit();
    oidn::FilterRef filter = device.newFilter("RT");
    filter.execute();
    Expect(device.getError(message) == oidn::Error::InvalidOperation, "a filter that is not committed");
    filter.commit();
    Expect(device.getError(message) == oidn::Error::InvalidOperation, "a filter without images");
    Expect(device.getError(message) == oidn::Error::None, "an error is told once");
}

#endif

int Run() {
#if LACQUER_HAS_OIDN
    Expect(HasOidn(), "it is built in");
    PixelsArriveAndReturn();
    Expect(state.alive == 0, "all handles are released");
    ParametersAreThoseOfTheDocumentation();
    FailuresAreMessages();
    TheDoubleIsStrict();
#else
    const Color image = Values(1);
    Expect(!HasOidn(), "it is not built in");
    Expect(WhyFailed(image, image, image).find("not built in") != std::string::npos, "and says so");
#endif
    std::printf("%d passed, %d failed\n", passed, failed);
    return failed ? 1 : 0;
}

}  // namespace
}  // namespace lacquer::denoise

int main() { return lacquer::denoise::Run(); }
