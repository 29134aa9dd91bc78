// lacquer render: from a scene file to an image.
#include "cmd/command.h"
#include "cmd/mpi/mpi_render.h"
#include "cmd/render/render_arguments.h"
#include "cmd/render/render_job.h"
#include "cmd/render/sequence.h"

namespace lacquer::cmd {

namespace {

ExitStatus RunRender(const RenderArguments& arguments) {
    if (arguments.mpi) return RunMpiRender(arguments);
    CheckArguments(arguments);
    if (!arguments.frames.empty()) return RunSequence(arguments);
    if (arguments.sandbox.isOn) EnterSandboxOf({&arguments, 1}, "");
    return RunRenderJob(arguments);
}

constexpr const char* kRenderSynopsis =
    "Lacquer renders pbrt-v4 scenes.\n"
    "Usage: lacquer [render] [OPTIONS] scene.pbrt ...\n"
    "Without a scene file, or with -, the scene is read from standard input.";
constexpr const char* kRenderFooter = R"(
Exit status: 0 the image is complete; 1 wrong usage; 2 the scene is wrong; 3 a file cannot be read or
written; 4 rendered, but with too many invalid samples; 5 the time limit came before --spp was
reached (the image is valid); 129, 130 or 143 stopped by a signal (the image so far is written).)";

}  // namespace

LACQUER_REGISTER(CommandKind, "render", (CommandOf<RenderArguments, AddRenderOptions, RunRender>::Make),
                 {.synopsis = kRenderSynopsis, .footer = kRenderFooter});

}  // namespace lacquer::cmd
