#include "pbrt/core/embedded.h"

#include <charconv>
#include <stdexcept>

namespace lacquer {

extern const EmbeddedFile kEmbeddedFiles[];

namespace {

const EmbeddedFile* Find(const EmbeddedFile* files, std::string_view name) {
    for (const EmbeddedFile* file = files; file->name; ++file)
        if (name == file->name) return file;
    return nullptr;
}

std::vector<double> NumbersOf(std::string_view line) {
    std::vector<double> row;
    line = line.substr(0, line.find('#'));
    while (true) {
        const size_t start = line.find_first_not_of(" \t\r");
        if (start == std::string_view::npos) return row;
        line.remove_prefix(start);
        const size_t length = std::min(line.find_first_of(" \t\r"), line.size());
        double value = 0;
        const auto [end, error] = std::from_chars(line.data(), line.data() + length, value);
        if (error == std::errc() && end == line.data() + length) row.push_back(value);
        line.remove_prefix(length);
    }
}

}  // namespace

bool HasEmbeddedData(std::string_view name) { return Find(kEmbeddedFiles, name) != nullptr; }

std::string_view EmbeddedData(std::string_view name) { return EmbeddedData(kEmbeddedFiles, name); }

std::string_view EmbeddedData(const EmbeddedFile* files, std::string_view name) {
    const EmbeddedFile* file = Find(files, name);
    if (!file) throw std::logic_error("no embedded file " + std::string(name));
    return {file->begin, size_t(file->end - file->begin)};
}

std::vector<std::string> EmbeddedNames(std::string_view folder) {
    std::vector<std::string> names;
    for (const EmbeddedFile* file = kEmbeddedFiles; file->name; ++file) {
        const std::string_view name = file->name;
        if (name.starts_with(folder)) names.emplace_back(name.substr(folder.size()));
    }
    return names;
}

std::vector<std::vector<double>> EmbeddedTable(std::string_view name) {
    std::string_view text = EmbeddedData(name);
    std::vector<std::vector<double>> rows;
    while (!text.empty()) {
        const size_t length = std::min(text.find('\n'), text.size());
        std::vector<double> row = NumbersOf(text.substr(0, length));
        text.remove_prefix(std::min(length + 1, text.size()));
        if (!row.empty()) rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace lacquer
