#include "cmd/report_error.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <new>

#include "cmd/command_support.h"
#include "cmd/mpi/manager.h"
#include "pbrt/base/film.h"
#include "pbrt/core/error.h"

namespace lacquer::cmd {

ExitStatus StatusOfError() {
    try {
        throw;
    } catch (const SceneErrors& e) {
        const bool filesOnly =
            std::all_of(e.Diagnostics().begin(), e.Diagnostics().end(),
                        [](const Diagnostic& d) { return d.cause == Diagnostic::Cause::File; });
        return filesOnly ? ExitStatus::File : ExitStatus::Scene;
    } catch (const OptionError&) {
        return ExitStatus::Usage;
    } catch (const SceneError&) {
        return ExitStatus::Scene;
    } catch (const FileError&) {
        return ExitStatus::File;
    } catch (const std::bad_alloc&) {
        return ExitStatus::Scene;
    } catch (const CLI::ValidationError&) {
        return ExitStatus::Usage;
    } catch (const OverrideError&) {
        return ExitStatus::Usage;
    } catch (const RankError& e) {
        return e.Status();
    } catch (const std::exception&) {
        return ExitStatus::Internal;
    }
}

ExitStatus ReportError(Console& console) {
    const ExitStatus status = StatusOfError();
    const auto print = [&](const FileLoc& loc, const std::string& message) {
        console.Error(Diagnostic{Diagnostic::Severity::Error, loc, message, Diagnostic::Cause::Scene});
    };
    try {
        throw;
    } catch (const SceneErrors& e) {
        for (const Diagnostic& d : e.Diagnostics()) console.Error(d);
    } catch (const SceneError& e) {
        print(e.Loc(), e.Message());
    } catch (const FileError& e) {
        print(e.Loc(), e.Message());
    } catch (const std::bad_alloc&) {
        console.Error("not enough memory for this scene");
    } catch (const std::exception& e) {
        console.Error(status == ExitStatus::Internal ? fmt::format("this is a bug in Lacquer: {}", e.what())
                                                     : std::string(e.what()));
    }
    return status;
}

}  // namespace lacquer::cmd
