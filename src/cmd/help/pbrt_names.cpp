#include "cmd/help/pbrt_names.h"

#include <cctype>
#include <span>

namespace lacquer::cmd {
namespace {

struct Answer {
    const char *name, *text;
};

constexpr const char* kNoWindow = "Lacquer renders on processors, and without a window";
constexpr Answer kOptions[] = {
    {"format", "lacquer convert scene.pbrt --format does so"},
    {"toply", "lacquer convert scene.pbrt --toply does so"},
    {"upgrade", "lacquer convert scene.pbrt --upgrade does so"},
    {"pixelmaterial", "--pixel X,Y --aov material, and lacquer info of the image, tell it"},
    {"debugstart", "--pixel X,Y --sample-range I:J, with J one more than I, renders one sample"},
    {"gpu", kNoWindow},
    {"gpudevice", kNoWindow},
    {"wavefront", kNoWindow},
    {"interactive", "Lacquer has no window; --display-server shows the image in tev while it renders"},
    {"fullscreen", "Lacquer has no window; --display-server shows the image in tev while it renders"},
    {"logutilization", "there is no such log; --stats tells what a render took"},
};

constexpr Answer kCommands[] = {
    {"imgtool", "its commands are those of lacquer itself, as in lacquer diff a.exr b.exr"},
    {"denoiseoptix", "it needs a graphics card; lacquer denoise does without"},
    {"scaleoptix", "it needs a graphics card; lacquer convert --resize does without"},
    {"plytool", "there is no counterpart; lacquer convert --toply writes PLY files of a scene"},
    {"cyhair2pbrt", "there is no counterpart; curves are read as pbrt has them"},
    {"nanovdb2pbrt", "there is no counterpart; files of NanoVDB are read as they are"},
    {"pspec", "there is no counterpart"},
};

/// Without dashes, in lower case: pbrt takes all spellings.
std::string Normalized(const std::string& name) {
    std::string result;
    for (const char c : name.substr(0, name.find('=')))
        if (c != '-' && c != '_') result += char(std::tolower((unsigned char)c));
    return result;
}

std::string Find(std::span<const Answer> answers, const std::string& name) {
    for (const Answer& answer : answers)
        if (answer.name == name) return answer.text;
    return {};
}

}  // namespace

std::string AnswerToPbrtOption(const std::string& argument) {
    return argument.starts_with('-') ? Find(kOptions, Normalized(argument)) : std::string();
}

std::string AnswerToPbrtCommand(const std::string& word) { return Find(kCommands, Normalized(word)); }

}  // namespace lacquer::cmd
