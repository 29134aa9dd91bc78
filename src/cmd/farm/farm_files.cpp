#include "cmd/farm/farm_files.h"

#include <fmt/format.h>

#include <cctype>
#include <filesystem>

#include "cmd/command_support.h"

namespace lacquer::cmd {
namespace {

std::string In(const FarmPlan& plan, const char* name) { return ShellWord(plan.folder + "/" + name); }

std::string Directives(const std::vector<std::string>& directives) {
    std::string lines;
    for (const std::string& directive : directives) lines += "#SBATCH " + directive + "\n";
    return lines;
}

std::string JobName(const FarmPlan& plan) {
    std::string name = std::filesystem::path(plan.outfile).stem().string();
    for (char& c : name)
        if (!std::isalnum((unsigned char)c)) c = '-';
    return name;
}

/// "#SBATCH" takes no quotes in file names, but knows this escape.
std::string SlurmPath(const std::string& path) {
    std::string escaped;
    for (const char c : path) {
        if (c == '%') escaped += '%';
        if (c == ' ' || c == '\\') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

std::string TaskScript(const FarmPlan& plan) {
    std::string script =
        "#!/bin/sh\n"
        "# Renders one part of an image: sh task.sh N. If it was stopped, it goes on when it is run again.\n"
        "set -eu\n"
        "case ${1-} in\n";
    for (size_t i = 0; i < plan.parts.size(); ++i)
        script += fmt::format("{}) set -- \"$1\" {} ;;\n", i + 1, plan.parts[i]);
    script += fmt::format("*) echo 'task.sh: a number from 1 to {} is expected' >&2; exit 1 ;;\nesac\n",
                          plan.parts.size());
    script += fmt::format(
        "part={}\"$1\"\n"
        "shift\n"
        "if [ -e \"$part.state\" ]; then set -- \"$@\" --resume \"$part.state\"; fi\n"
        "exec {} render {} {} \"$@\" \\\n"
        "    --checkpoint \"$part.state\" --outfile \"$part.exr\" --quiet\n",
        In(plan, "part-"), ShellWord(plan.program), ShellWord(plan.scene), plan.options);
    return script;
}

std::string TaskList(const FarmPlan& plan) {
    std::string lines;
    for (size_t i = 1; i <= plan.parts.size(); ++i)
        lines += fmt::format("sh {} {}\n", In(plan, "task.sh"), i);
    return lines;
}

std::string MergeScript(const FarmPlan& plan) {
    return fmt::format(
        "#!/bin/sh\n"
        "# Makes the image of all parts, if no sample is missing and none is there twice.\n"
        "exec {} merge {}*.state --outfile {} \"$@\"\n",
        ShellWord(plan.program), In(plan, "part-"), ShellWord(plan.outfile));
}

std::string SlurmTasks(const FarmPlan& plan, const std::vector<std::string>& directives) {
    return fmt::format(
        "#!/bin/sh\n"
        "#SBATCH --job-name={0}\n"
        "#SBATCH --array=1-{1}\n"
        "#SBATCH --requeue\n"
        "#SBATCH --open-mode=append\n"
        "#SBATCH --signal=B:USR1@90\n"
        "#SBATCH --output={2}/log-%a.txt\n"
        "{3}"
        "# USR1 comes before the time limit: the state is written, and the task waits for its next turn.\n"
        "# TERM comes before a preemption, after which Slurm requeues the task itself, and from scancel.\n"
        "again=\n"
        "sh {4} \"$SLURM_ARRAY_TASK_ID\" & task=$!\n"
        "trap 'again=yes; kill -TERM $task' USR1\n"
        "trap 'kill -TERM $task' TERM\n"
        "wait $task; status=$?\n"
        "while kill -0 $task 2>/dev/null; do wait $task; status=$?; done\n"
        "if [ -n \"$again\" ] && [ $status -ne 0 ]; then\n"
        "    scontrol requeue \"${{SLURM_ARRAY_JOB_ID}}_$SLURM_ARRAY_TASK_ID\"\n"
        "fi\n"
        "exit $status\n",
        JobName(plan), plan.parts.size(), SlurmPath(plan.folder), Directives(directives),
        In(plan, "task.sh"));
}

std::string SlurmMerge(const FarmPlan& plan, const std::vector<std::string>& directives) {
    return fmt::format(
        "#!/bin/sh\n"
        "#SBATCH --job-name={}-merge\n"
        "#SBATCH --requeue\n"
        "#SBATCH --open-mode=append\n"
        "#SBATCH --output={}/log-merge.txt\n"
        "{}"
        "exec sh {}\n",
        JobName(plan), SlurmPath(plan.folder), Directives(directives), In(plan, "merge.sh"));
}

std::string SlurmSubmission(const FarmPlan& plan) {
    return fmt::format(
        "#!/bin/sh\n"
        "# Hands the tasks to Slurm, and what makes the image once all of them have succeeded.\n"
        "set -eu\n"
        "tasks=$(sbatch --parsable {})\n"
        "merge=$(sbatch --parsable --dependency=afterok:\"${{tasks%%;*}}\" --kill-on-invalid-dep=yes {})\n"
        "echo \"tasks: job $tasks; image: job $merge\"\n",
        In(plan, "tasks.sbatch"), In(plan, "merge.sbatch"));
}

/// Parts of two renders in one folder would be taken for one.
void CheckFolder(const std::string& folder) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with("part-") || name == "task.sh")
            throw FileError(entry.path().string(),
                            "is of an earlier render in parts; choose another --folder, or remove it");
    }
}

}  // namespace

std::string ShellWord(const std::string& text) {
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

void WriteFarmFiles(const FarmPlan& plan, const std::vector<std::string>& slurm) {
    CheckFolder(plan.folder);
    const auto write = [&](const char* name, const std::string& text) {
        WriteText(plan.folder + "/" + name, text);
    };
    write("task.sh", TaskScript(plan));
    write("tasks.txt", TaskList(plan));
    write("merge.sh", MergeScript(plan));
    write("tasks.sbatch", SlurmTasks(plan, slurm));
    write("merge.sbatch", SlurmMerge(plan, slurm));
    write("submit.sh", SlurmSubmission(plan));
}

}  // namespace lacquer::cmd
