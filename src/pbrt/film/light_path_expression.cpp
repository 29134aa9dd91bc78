#include "pbrt/film/light_path_expression.h"

#include <fmt/format.h>

#include <algorithm>

#include "pbrt/core/error.h"

namespace lacquer {

namespace {

/// Nested parentheses and elements that one expression may have.
constexpr int kMaxDepth = 64;
constexpr size_t kMaxElements = 256;
constexpr const char* kEvents = "D, G, S, R, T, V, L, B, O, \".\", \"<\", \"[\" or \"(\"";

PathSymbols EventsOf(std::initializer_list<PathEvent> events) {
    PathSymbols symbols;
    for (const PathEvent event : events) symbols.set(size_t(event));
    return symbols;
}

/// What a letter stands for; empty for one that means nothing.
PathSymbols SymbolsOf(char letter) {
    using enum PathEvent;
    PathSymbols symbols;
    const auto ends = [&](std::initializer_list<PathSource> sources) {
        for (size_t group = 0; group <= kMaxLightGroups; ++group)
            for (const PathSource source : sources) symbols.set(SymbolOf(source, group));
        return symbols;
    };
    switch (letter) {
        case 'D':
            return EventsOf({DiffuseReflection, DiffuseTransmission});
        case 'G':
            return EventsOf({GlossyReflection, GlossyTransmission});
        case 'S':
            return EventsOf({SpecularReflection, SpecularTransmission});
        case 'R':
            return EventsOf({DiffuseReflection, GlossyReflection, SpecularReflection});
        case 'T':
            return EventsOf({DiffuseTransmission, GlossyTransmission, SpecularTransmission});
        case 'V':
            return EventsOf({Volume});
        case 'L':
            return ends({PathSource::Light, PathSource::Background});
        case 'B':
            return ends({PathSource::Background});
        case 'O':
            return ends({PathSource::Medium});
        case '.':
            return symbols.set();
        default:
            return symbols;
    }
}

/// Recursive descent.
class ExpressionReader {
  public:
    ExpressionReader(const std::string& text, int expression, const std::vector<std::string>* groups,
                     PathPositions* out)
        : text_(text), expression_(expression), groups_(groups), out_(*out) {}

    int Read() {
        if (Peek() != 'C') Fail(at_, "\"C\", the camera, begins an expression");
        ++at_;
        const int start = NewPosition({});
        if (AtEnd()) Fail(at_, fmt::format("expected what follows the camera: {}", kEvents));
        const Fragment all = Sequence(0);
        if (!AtEnd())
            Fail(at_, Peek() == '|' ? "\"|\" stands in parentheses only, as in C(D|V)L"
                                    : fmt::format("\"{}\" closes nothing", Shown()));
        At(start).followers = all.first;
        for (const int i : all.last) At(i).isLast = true;
        return start;
    }

  private:
    /// Part of an expression: where it can begin and end.
    struct Fragment {
        bool canBeEmpty = true;
        std::vector<int> first = {}, last = {};
    };

    Fragment Sequence(int depth) {
        Fragment all;
        while (!AtEnd() && Peek() != ')' && Peek() != '|') {
            const Fragment next = Repeated(depth);
            Connect(all.last, next.first);
            if (all.canBeEmpty) Append(&all.first, next.first);
            if (!next.canBeEmpty) all.last.clear();
            Append(&all.last, next.last);
            all.canBeEmpty &= next.canBeEmpty;
        }
        return all;
    }

    Fragment Repeated(int depth) {
        Fragment part = Element(depth);
        while (!AtEnd() && (Peek() == '*' || Peek() == '+' || Peek() == '?')) {
            const char how = text_[at_++];
            if (how != '?') Connect(part.last, part.first);
            if (how != '+') part.canBeEmpty = true;
        }
        return part;
    }

    Fragment Element(int depth) {
        const size_t begin = at_;
        if (Peek() == '(') {
            if (depth == kMaxDepth) Fail(begin, "too many parentheses within each other");
            return Alternatives(depth + 1);
        }
        PathSymbols symbols;
        if (Peek() == '[')
            symbols = Set();
        else if (Peek() == '<')
            symbols = Angle();
        else
            symbols = Letter(fmt::format("expected {}", kEvents));
        const int position = NewPosition(symbols);
        return {false, {position}, {position}};
    }

    Fragment Alternatives(int depth) {
        const size_t open = at_++;
        Fragment all = Sequence(depth);
        while (Peek() == '|') {
            ++at_;
            const Fragment other = Sequence(depth);
            Append(&all.first, other.first);
            Append(&all.last, other.last);
            all.canBeEmpty |= other.canBeEmpty;
        }
        if (Peek() != ')') Fail(open, "this \"(\" is never closed");
        ++at_;
        return all;
    }

    PathSymbols Letter(const std::string& expected) {
        const char c = Peek();
        if (c == 'C') Fail(at_, "\"C\", the camera, stands at the beginning only");
        if (c == '*' || c == '+' || c == '?') Fail(at_, fmt::format("\"{}\" has nothing to repeat", c));
        const PathSymbols symbols = SymbolsOf(c);
        if (AtEnd()) Fail(at_, expected);
        if (symbols.none()) Fail(at_, fmt::format("\"{}\" is no event; {}", Shown(), expected));
        ++at_;
        return symbols;
    }

    /// [...] or [^...].
    PathSymbols Set() {
        const size_t open = at_++;
        const bool isNegated = Peek() == '^';
        if (isNegated) ++at_;
        PathSymbols symbols;
        if (Peek() == ']') Fail(at_, "the set is empty; expected letters of events");
        while (Peek() != ']') {
            if (AtEnd()) Fail(open, "this \"[\" is never closed");
            symbols |= Peek() == '<' ? Angle() : Letter("expected letters of events or \"]\"");
        }
        ++at_;
        return isNegated ? ~symbols : symbols;
    }

    /// <RD>, <T.>, <[RT]G>, <L'key'>, <L.'key'>: what all its parts have in common.
    PathSymbols Angle() {
        const size_t open = at_++;
        PathSymbols symbols;
        symbols.set();
        int parts = 0;
        while (Peek() != '>') {
            if (AtEnd()) Fail(open, "this \"<\" is never closed");
            const size_t begin = at_;
            if (Peek() == '\'') {
                symbols &= Label(symbols);
                if (Peek() != '>') Fail(at_, "expected \">\" after the light group");
                break;
            }
            if (parts++ == 2) Fail(at_, "expected \">\" or a light group in single quotes");
            symbols &=
                Peek() == '[' ? Set() : Letter("expected a letter, \".\", \"[\", a light group or \">\"");
            if (symbols.none()) Fail(begin, "no event is this and what stands before it");
        }
        if (parts == 0 && symbols.all()) Fail(at_, "expected a letter of an event");
        ++at_;
        return symbols;
    }

    PathSymbols Label(const PathSymbols& before) {
        const size_t open = at_++;
        const size_t close = text_.find('\'', at_);
        if (close == std::string::npos) Fail(open, "this quote is never closed");
        const std::string name = text_.substr(at_, close - at_);
        if (name.empty()) Fail(open, "the name of the light group is empty");
        at_ = close + 1;
        if ((before & (SymbolsOf('L') | SymbolsOf('O'))).none())
            Fail(open, "only lights have groups: L, B and O");
        PathSymbols symbols;
        if (!groups_) return symbols.set();
        const auto group = std::find(groups_->begin(), groups_->end(), name);
        if (group == groups_->end())
            Fail(open, fmt::format("the scene has no light group \"{}\"{}", Excerpt(name),
                                   DidYouMean(name, {groups_->begin() + 1, groups_->end()})));
        for (int source = 0; source < kNumPathSources; ++source)
            symbols.set(SymbolOf(PathSource(source), size_t(group - groups_->begin())));
        return symbols;
    }

    PathPositions::Position& At(int position) { return out_.positions[size_t(position)]; }
    int NewPosition(const PathSymbols& symbols) {
        if (numElements_++ > kMaxElements) Fail(at_, "the expression is too long");
        out_.positions.push_back({symbols, {}, expression_, false});
        return int(out_.positions.size()) - 1;
    }
    static void Append(std::vector<int>* list, const std::vector<int>& more) {
        list->insert(list->end(), more.begin(), more.end());
    }
    void Connect(const std::vector<int>& from, const std::vector<int>& to) {
        for (const int i : from) {
            std::vector<int>& followers = At(i).followers;
            Append(&followers, to);
            std::sort(followers.begin(), followers.end());
            followers.erase(std::unique(followers.begin(), followers.end()), followers.end());
        }
    }

    bool AtEnd() const { return at_ >= text_.size(); }
    /// The next character; 0 at the end.
    char Peek() const { return AtEnd() ? '\0' : text_[at_]; }
    std::string Shown() const { return Excerpt(text_.substr(at_, 1)); }
    [[noreturn]] void Fail(size_t at, const std::string& why) const {
        // A mark below the text shows the place where the text has one column for each byte.
        constexpr size_t kMaxShown = 100;
        const bool isPlain =
            std::all_of(text_.begin(), text_.end(), [](char c) { return c >= ' ' && c <= '~'; });
        std::string mark;
        if (isPlain && text_.size() <= kMaxShown)
            mark = fmt::format("\n    {}\n    {:>{}}", text_, '^', at + 1);
        throw LightPathError(fmt::format("light path expression, character {}: {}{}", at + 1, why, mark));
    }

    const std::string& text_;
    int expression_;
    const std::vector<std::string>* groups_;
    PathPositions& out_;
    size_t at_ = 0, numElements_ = 0;
};

}  // namespace

int PathPositions::Add(const std::string& text, int expression, const std::vector<std::string>* groups) {
    return ExpressionReader(text, expression, groups, this).Read();
}

}  // namespace lacquer
