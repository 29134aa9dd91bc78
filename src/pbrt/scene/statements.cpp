#include "pbrt/scene/statements.h"

#include <fmt/format.h>

#include <algorithm>

#include "pbrt/scene/directive.h"
#include "pbrt/scene/parameter_list.h"

namespace lacquer {

namespace {

/// A token with the comments around it.
struct Item {
    Token token;
    std::vector<std::string> before;  ///< on lines of their own; an empty one is a blank line
    std::string behind;               ///< on the token's line
};

/// Tokens with their comments, one ahead.
class ItemReader {
  public:
    explicit ItemReader(Source source) : lexer_(std::move(source), Lexer::Comments::Keep) { Fetch(); }
    const Item& Peek() const { return ahead_; }
    Item Next() {
        Item item = std::move(ahead_);
        if (item.token.kind != Token::Kind::End) Fetch();
        return item;
    }

  private:
    void Fetch() {
        ahead_ = {};
        Token token = lexer_.Next();
        for (; token.kind == Token::Kind::Comment; token = lexer_.Next()) {
            NoteLine(token.line);
            ahead_.before.emplace_back(token.text);
        }
        if (token.kind != Token::Kind::End) NoteLine(token.line);
        ahead_.token = token;
        const Token& next = lexer_.Peek();
        if (token.kind == Token::Kind::End || next.kind != Token::Kind::Comment || next.line != token.line)
            return;
        ahead_.behind = std::string(next.text);
        lexer_.Next();
    }

    /// Blank lines before this one become one empty comment.
    void NoteLine(int line) {
        if (lastLine_ > 0 && line > lastLine_ + 1) ahead_.before.emplace_back();
        lastLine_ = line;
    }

    Lexer lexer_;
    Item ahead_;
    int lastLine_ = 0;
};

class Reader {
  public:
    explicit Reader(const Source& source) : items_(source) { scene_.memory = source.memory; }

    SceneText Read() {
        while (items_.Peek().token.kind != Token::Kind::End)
            scene_.directives.push_back(ReadDirective(items_.Next()));
        scene_.commentsAtEnd = items_.Next().before;
        return std::move(scene_);
    }

  private:
    using Kind = Token::Kind;

    WrittenValue ValueOf(const Token& token) {
        const bool isString = token.kind == Kind::String;
        // Words point into the text. A string that had escapes does not, and strings are few.
        return {isString ? scene_.Own(std::string(token.text)) : token.text, isString};
    }

    /// Comments where none is written again move before what is being read.
    static void Move(const std::vector<std::string>& comments, std::vector<std::string>* to) {
        for (const std::string& comment : comments)
            if (!comment.empty()) to->push_back(comment);
    }
    static void Move(const std::string& comment, std::vector<std::string>* to) {
        if (!comment.empty()) to->push_back(comment);
    }

    WrittenDirective ReadDirective(Item item) {
        WrittenDirective directive;
        directive.name = std::string(item.token.text);
        directive.loc = item.token.Loc();
        directive.commentsBefore = std::move(item.before);
        directive.commentBehind = std::move(item.behind);
        const Directive* known = FindDirective(item.token.text);
        if (item.token.kind != Kind::Word || !known) FailAsUnknown(item.token);
        for (const Argument argument : known->arguments) {
            const ArgumentForm& form = FormOf(argument);
            if (argument == Argument::Parameters)
                while (items_.Peek().token.kind == Kind::String)
                    directive.parameters.push_back(ReadParameter());
            else if (!form.isOptional || items_.Peek().token.kind == Kind::String)
                for (size_t i = 0; i < form.numTokens; ++i) Take(argument, i, &directive);
        }
        return directive;
    }

    [[noreturn]] static void FailAsUnknown(const Token& token) {
        throw SceneError(token.Loc(), fmt::format("expected a directive, found {}{}", token.Excerpt(),
                                                  DidYouMean(token.text.substr(0, 100), DirectiveNames())));
    }

    /// A token of an argument.
    void Take(Argument argument, size_t i, WrittenDirective* directive) {
        Item item = items_.Next();
        if (item.token.kind == Kind::End) FailAtEnd(directive->name, argument, i, directive->loc);
        CheckToken(directive->name, argument, i, item.token);
        const bool isBracket = item.token.kind == Kind::Open || item.token.kind == Kind::Close;
        if (!isBracket) directive->arguments.push_back(ValueOf(item.token));
        // What stood behind the last token is not at the end any more.
        Move(directive->commentBehind, &directive->commentsBefore);
        Move(item.before, &directive->commentsBefore);
        directive->commentBehind = std::move(item.behind);
    }

    WrittenParameter ReadParameter() {
        Item declaration = items_.Next();
        WrittenParameter p;
        p.loc = declaration.token.Loc();
        Move(declaration.before, &p.commentsBefore);
        Move(declaration.behind, &p.commentsBefore);
        ReadDeclaration(declaration.token, &p);
        Item item = items_.Next();
        const FileLoc open = item.token.Loc();
        Move(item.before, &p.commentsBefore);
        if (item.token.kind != Kind::Open) {
            p.values.push_back(ReadValue(item.token, p));
            p.commentBehind = std::move(item.behind);
            return p;
        }
        while (true) {
            Move(item.behind, &p.commentsBefore);
            item = items_.Next();
            Move(item.before, &p.commentsBefore);
            if (item.token.kind == Kind::End)
                throw SceneError(open, "the list of values is never closed: the file ends before its ]");
            if (item.token.kind == Kind::Close) break;
            p.values.push_back(ReadValue(item.token, p));
        }
        p.commentBehind = std::move(item.behind);
        return p;
    }

    static void ReadDeclaration(const Token& token, WrittenParameter* p) {
        const std::vector<std::string_view> words = SplitAtBlanks(token.text);
        if (words.size() != 2)
            throw SceneError(p->loc,
                             fmt::format("the parameter declaration {} has {} words; expected \"type name\"",
                                         token.Excerpt(), words.size()));
        p->type = words[0];
        p->name = words[1];
    }

    WrittenValue ReadValue(const Token& token, const WrittenParameter& p) {
        const bool isBool = token.kind == Kind::Word && (token.text == "true" || token.text == "false");
        if (token.kind == Kind::End) throw SceneError(p.loc, "the file ends before the parameter's value");
        if (token.kind != Kind::String && !isBool) ExpectFloat(token);
        return ValueOf(token);
    }

    SceneText scene_;
    ItemReader items_;
};

/// Directives as text.
class Writer {
  public:
    std::string Write(const SceneText& scene) {
        for (const WrittenDirective& directive : scene.directives) Write(directive);
        WriteComments(scene.commentsAtEnd);
        return std::move(out_);
    }

  private:
    static constexpr size_t kWidth = 110, kIndent = 4;

    static std::string Text(const WrittenValue& v) {
        return v.isString ? QuotedText(v.text) : std::string(v.text);
    }

    /// `"type name" value`, or with a list in brackets, on one line.
    static std::string Head(const WrittenParameter& p) { return QuotedText(p.type + " " + p.name); }
    static std::string OnOneLine(const WrittenParameter& p) {
        std::string text = Head(p);
        if (p.values.size() == 1) return text + " " + Text(p.values[0]);
        text += " [";
        for (const WrittenValue& v : p.values) (text += ' ') += Text(v);
        return text + " ]";
    }

    void NewLine(size_t indent) {
        out_ += '\n';
        out_.append(indent, ' ');
    }
    void WriteComments(const std::vector<std::string>& comments) {
        for (const std::string& comment : comments) {
            if (!comment.empty()) out_.append(Indent(), ' ');
            out_ += comment + "\n";
        }
    }
    size_t Indent() const { return kIndent * depth_; }

    void Write(const WrittenDirective& d) {
        WriteComments(d.commentsBefore);
        const Directive* known = FindDirective(d.name);
        const Directive::Scope scope = known ? known->scope : Directive::Scope::None;
        if (scope == Directive::Scope::Closes && depth_ > 0) --depth_;
        out_.append(Indent(), ' ');
        const bool isMatrix = known && known->Has(Argument::Matrix);
        std::string line = d.name;
        if (isMatrix) line += " [";
        for (const WrittenValue& v : d.arguments) (line += ' ') += Text(v);
        if (isMatrix) line += " ]";
        out_ += line;
        if (!FitsBehind(d, line.size()))
            WriteParameters(d);
        else
            for (const WrittenParameter& p : d.parameters) out_ += " " + OnOneLine(p);
        const std::string& comment =
            d.parameters.empty() ? d.commentBehind : d.parameters.back().commentBehind;
        if (!comment.empty()) out_ += "  " + comment;
        out_ += '\n';
        if (scope == Directive::Scope::Opens) ++depth_;
    }

    /// True if all parameters go onto the directive's line: no comment stands between them, and they are
    /// short.
    bool FitsBehind(const WrittenDirective& d, size_t width) const {
        constexpr size_t kMaxValues = 64;
        if (!d.parameters.empty() && !d.commentBehind.empty()) return false;
        width += Indent();
        for (const WrittenParameter& p : d.parameters) {
            if (!p.commentsBefore.empty() || p.values.size() > kMaxValues) return false;
            if (!p.commentBehind.empty() && &p != &d.parameters.back()) return false;
            width += 1 + OnOneLine(p).size();
            if (width > kWidth) return false;
        }
        return true;
    }

    /// One a line; the comment behind the last one is left to the caller.
    void WriteParameters(const WrittenDirective& d) {
        if (!d.commentBehind.empty()) out_ += "  " + d.commentBehind;
        const size_t indent = Indent() + kIndent;
        for (const WrittenParameter& p : d.parameters) {
            for (const std::string& comment : p.commentsBefore) {
                NewLine(indent);
                out_ += comment;
            }
            NewLine(indent);
            WriteValues(p, indent);
            if (!p.commentBehind.empty() && &p != &d.parameters.back()) out_ += "  " + p.commentBehind;
        }
    }

    /// Fills lines with values.
    void WriteValues(const WrittenParameter& p, size_t indent) {
        out_ += Head(p);
        if (p.values.size() == 1) {
            out_ += " " + Text(p.values[0]);
            return;
        }
        out_ += " [";
        size_t column = indent + Head(p).size() + 2;
        for (const WrittenValue& v : p.values) {
            const std::string text = Text(v);
            if (column + 1 + text.size() > kWidth) {
                NewLine(indent + kIndent - 1);
                column = indent + kIndent - 1;
            }
            (out_ += ' ') += text;
            column += 1 + text.size();
        }
        out_ += " ]";
    }

    std::string out_;
    size_t depth_ = 0;
};

}  // namespace

WrittenParameter* WrittenDirective::Find(std::string_view parameter) {
    const auto found = std::find_if(parameters.begin(), parameters.end(),
                                    [&](const WrittenParameter& p) { return p.name == parameter; });
    return found == parameters.end() ? nullptr : &*found;
}

std::string QuotedText(std::string_view text) {
    std::string quoted = "\"";
    for (const char c : text) {
        const size_t found = std::string_view("\b\f\n\r\t\\\"").find(c);
        if (found == std::string_view::npos)
            quoted += c;
        else
            (quoted += '\\') += "bfnrt\\\""[found];
    }
    return quoted + "\"";
}

SceneText ReadSceneText(const Source& source) { return Reader(source).Read(); }

std::string WriteSceneText(const SceneText& scene) { return Writer().Write(scene); }

}  // namespace lacquer
