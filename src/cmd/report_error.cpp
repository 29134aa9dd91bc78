#include "cmd/report_error.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <new>

#include "cmd/command_support.h"
#include "pbrt/base/film.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {

ExitStatus ReportError(Console& console) {
    try {
        throw;
    } catch (const SceneErrors& e) {
        for (const Diagnostic& d : e.Diagnostics()) console.Error(d);
        const bool filesOnly =
            std::all_of(e.Diagnostics().begin(), e.Diagnostics().end(),
                        [](const Diagnostic& d) { return d.cause == Diagnostic::Cause::File; });
        return filesOnly ? ExitStatus::File : ExitStatus::Scene;
    } catch (const OptionError& e) {
        console.Error(
            Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::Scene});
        return ExitStatus::Usage;
    } catch (const SceneError& e) {
        console.Error(
            Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::Scene});
        return ExitStatus::Scene;
    } catch (const FileError& e) {
        console.Error(Diagnostic{Diagnostic::Severity::Error, e.Loc(), e.Message(), Diagnostic::Cause::File});
        return ExitStatus::File;
    } catch (const std::bad_alloc&) {
        console.Error("not enough memory for this scene");
        return ExitStatus::Scene;
    } catch (const CLI::ValidationError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const OverrideError& e) {
        console.Error(e.what());
        return ExitStatus::Usage;
    } catch (const std::exception& e) {
        console.Error(fmt::format("this is a bug in Lacquer: {}", e.what()));
        return ExitStatus::Internal;
    }
}

}  // namespace lacquer::cmd
