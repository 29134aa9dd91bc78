// Names of files, each kept once: every parameter of a scene has the place where it stands.
#pragma once

#include <compare>
#include <string>
#include <string_view>

namespace lacquer {

/// The name of a file, as large as a pointer and copied as fast. Names that were used once stay for as long
/// as the program runs. Thread-safe.
class FileName {
  public:
    FileName() = default;
    FileName(std::string_view name);
    FileName(const std::string& name) : FileName(std::string_view(name)) {}
    FileName(const char* name) : FileName(std::string_view(name)) {}

    operator const std::string&() const { return *name_; }
    const std::string& Text() const { return *name_; }
    bool IsEmpty() const { return name_->empty(); }

    friend bool operator==(FileName a, FileName b) { return a.name_ == b.name_; }
    friend std::strong_ordering operator<=>(FileName a, FileName b) { return *a.name_ <=> *b.name_; }

  private:
    static const std::string* Empty();
    const std::string* name_ = Empty();
};

}  // namespace lacquer
