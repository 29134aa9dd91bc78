"""What a C++ file declares, by its text: enough of the language for the checks of this folder, and no compiler.

Works on what `.clang-format` leaves: declarations of namespaces and of classes, with their braces. Macros are not expanded.
"""
import os
import re
from dataclasses import dataclass

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


@dataclass
class Entity:
    kind: str          # "type", "alias", "function", "variable" or "using" (using A::name;)
    namespace: str     # "lacquer::layered"
    name: str          # of a function in a class: "Class::Name"
    parameters: str    # of a function: its types as written, without names and defaults; of an alias what it stands for
    path: str
    line: int
    last: int          # last line
    defined: bool      # rather than only declared
    local: bool        # seen by its own translation unit only
    member: bool       # of a class


def files(*folders):
    """Paths of the C++ files below folders of the repository, relative to it."""
    for top in folders:
        for folder, _, names in os.walk(os.path.join(ROOT, top)):
            for name in sorted(names):
                if name.endswith((".h", ".cpp")):
                    yield os.path.relpath(os.path.join(folder, name), ROOT).replace(os.sep, "/")


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


_NOISE = re.compile(r'R"(?P<mark>[^()\s]*)\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|(?<![0-9a-fA-F])\'(?:\\.|[^\'\\\n])+\''
                    r"|//[^\n]*|/\*.*?\*/|^[ \t]*#(?:\\\n|[^\n])*", re.S | re.M)


def bare(text):
    """The text without comments, directives and what literals hold; lines stay where they are."""
    def blank(match):
        kept = '""' if match.group(0)[0] in "\"'R" else ""
        return kept + "\n" * match.group(0).count("\n")
    return _NOISE.sub(blank, text)


def _without_templates(head):
    """The head of a declaration without template<...>, attributes and macros before it."""
    head = re.sub(r"\[\[.*?\]\]", "", head).strip()
    head = re.sub(r"^(?:[A-Z][A-Z0-9_]{3,}(?:\([^()]*\))?\s+)+(?=[A-Za-z_])", "", head)
    while head.startswith("template"):
        depth = 0
        for i, c in enumerate(head):
            depth += (c == "<") - (c == ">")
            if depth == 0 and c == ">":
                break
        head = re.sub(r"^requires\s*\(.*?\)\s*", "", head[i + 1:].strip())
    return head


def _split(text, separator=","):
    """Parts between separators that stand in no brackets."""
    parts, depth, start = [], 0, 0
    for i, c in enumerate(text):
        if c in "(<[{":
            depth += 1
        elif c in ")>]}" and text[i - 1] != "-":
            depth -= 1
        elif c == separator and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    return parts + [text[start:]]


def _type_of(parameter):
    parameter = _split(parameter, "=")[0].strip()
    parameter = re.sub(r"(?<=[\w>&*\]\)])\s*\b(?!const\b|int\b|float\b|double\b|bool\b|char\b)[A-Za-z_]\w*(\s*\[\w*\])?$", r"\1",
                       parameter) if re.search(r"[\s&*>]\w+(\[\w*\])?$", parameter) else parameter
    return re.sub(r"\s+", " ", re.sub(r"^const (?!.*[&*])", "", parameter)).strip()


_TYPE = re.compile(r"(?:typedef\s+)?(class|struct|union|enum(?:\s+(?:class|struct))?)\s+(?:alignas\s*\([^)]*\)\s*)?"
                   r"([A-Za-z_]\w*(?:::\w+)*)\s*(<.*>)?\s*(?:final\b)?\s*(?::[^:].*)?$", re.S)
# What stands before the body of a lambda.
_LAMBDA = re.compile(r"(?:^|[^\w\s\])])\s*\[[^\[\]]*\]\s*(?:\([^{}]*\))?\s*(?:mutable\b|noexcept\b|constexpr\b|->[^{}()]*|\s)*$")
_FUNCTION = re.compile(r"(?:^|[\s*&>])((?:[A-Za-z_]\w*(?:<[^()<>]*(?:<[^()<>]*>[^()<>]*)*>)?\s*::\s*)*"
                       r"(?:~?[A-Za-z_]\w*|operator\s*(?:\(\)|[^\s(]+|\w+)))\s*\(")


def _function(head, has_body=False):
    """Name and parameters of the function that a head declares, or None. What looks like LACQUER_NAME(...) is one if it has
    a body."""
    head = _without_templates(head)
    before = _split(head, "=")[0] if "operator" not in head else head
    match = _FUNCTION.search(before)
    if not match or re.match(r"(using|return|static_assert|friend\s+class)\b", head):
        return None
    if head.startswith("LACQUER_") and not has_body:
        return None
    name = re.sub(r"\s+", "", match.group(1)).replace("operator", "operator ")
    if re.fullmatch(r"if|for|while|switch|catch|return", name):
        return None
    # The closing bracket of the parameters.
    depth, begin = 0, match.end() - 1
    for end in range(begin, len(head)):
        depth += (head[end] == "(") - (head[end] == ")")
        if depth == 0:
            break
    parameters = head[begin + 1:end].strip()
    types = [] if parameters in ("", "void") else [_type_of(p) for p in _split(parameters)]
    return name, ", ".join(types)


def scan(path, text=None):
    """All entities of namespaces, and the functions of classes with a body, of one file."""
    code = bare(read(path) if text is None else text)
    header = path.endswith(".h")
    found, scopes = [], []          # scopes: [kind, name, entity or None, head before]
    head, head_line, line, parens = "", 1, 1, 0

    def namespace():
        return "::".join(s[1] for s in scopes if s[0] == "namespace" and s[1])

    def is_local(text):
        hidden = any(s[0] == "namespace" and not s[1] for s in scopes)
        return hidden or bool(re.match(r"(template\b.*?>\s*)?static\b", text.strip(), re.S))

    def add(kind, name, parameters="", defined=True, local=False, member=False):
        found.append(Entity(kind, namespace(), name, parameters, path, head_line, line, defined, local, member))
        return found[-1]

    def add_lambda():
        entity = add("function", "lambda", local=True, member=True)
        entity.line = line
        return entity

    def open_brace():
        """What the brace after `head` opens, and the entity that it defines."""
        text = head.strip()
        inner = scopes[-1][0] if scopes else "namespace"
        if inner == "block":
            return "block", "", None
        match = re.match(r"(?:inline\s+)?namespace\b\s*([\w:]*)$", text)
        if match:
            return "namespace", match.group(1), None
        if re.match(r'extern\s*""$', text):
            return "class", "", None
        plain = _without_templates(text)
        match = _TYPE.match(plain)
        if match:
            entity = None
            if inner == "namespace" and not match.group(3) and "::" not in match.group(2):
                entity = add("type", match.group(2), local=is_local(text))
            return ("block" if match.group(1).startswith("enum") else "class"), match.group(2), entity
        if re.search(r"[\w>]$", head) and (re.search(r"\)\s*:(?!:)", plain) or "(" not in plain):
            return "init", "", None      # a member or a variable, initialised by braces
        function = _function(text, has_body=True)
        if function and not re.search(r"(?<![=!<>])=\s*$", text):
            owners = [s[1] for s in scopes if s[0] == "class" and s[1]]
            name = "::".join(owners + [function[0]])
            member = inner == "class" or "::" in function[0]
            return "block", "", add("function", name, function[1], local=is_local(text), member=member)
        return "init", "", None

    def statement():
        """Records the declaration `head`, which ended with a semicolon."""
        text = head.strip()
        if not text or (scopes and scopes[-1][0] != "namespace"):
            return
        plain = _without_templates(text)
        match = re.match(r"using\s+(?!namespace)(\w+)\s*=\s*(.*)$", plain, re.S)
        if match:
            add("alias", match.group(1), "" if plain != text else match.group(2), local=is_local(text))
            return
        match = re.match(r"using\s+([\w:]+)$", plain)
        if match:
            add("using", match.group(1).split("::")[-1], local=is_local(text))
            return
        match = re.match(r"typedef\b(.*?)(\w+)$", plain, re.S)
        if match:
            defines = re.match(r"\s*(?:struct|class|union|enum)\b.*\{\}\s*$", match.group(1), re.S)
            add("type" if defines else "alias", match.group(2), match.group(1).strip(), local=is_local(text))
            return
        if re.match(r"(class|struct|enum|union|using|static_assert|template|namespace)\b", plain):
            return
        function = _function(text)
        if function:
            if "::" not in function[0]:
                add("function", function[0], function[1], defined=False, local=is_local(text))
            return
        match = re.match(r"[\w:<>,\s*&]*?[\s*&>](\w+)\s*(\[.*\])?\s*(=.*|\{.*)?$", plain, re.S)
        if match and not text.startswith("LACQUER_"):
            internal = bool(re.search(r"\b(const|constexpr)\b", plain.split("=")[0])) and "inline" not in plain \
                and not plain.startswith("extern") and not header
            add("variable", match.group(1), defined=not plain.startswith("extern"), local=is_local(text) or internal)

    for token in re.split(r"([\n(){}\[\];:])", code):
        if token == "\n":
            line += 1
        parens += (token in ("(", "[")) - (token in (")", "]"))
        inside = parens > 0 or (scopes and scopes[-1][0] == "nested")
        if token == "{":
            # A lambda that no function holds is a function itself.
            outermost = not any(s[0] == "block" or (s[2] and s[2].name == "lambda") for s in scopes)
            opens_lambda = outermost and _LAMBDA.search(head)
            if inside:
                scopes.append(["nested", "", add_lambda() if opens_lambda else None, head, parens])
                parens = 0
                continue
            kind, name, entity = open_brace()
            if kind == "init" and opens_lambda:
                entity = add_lambda()
            scopes.append([kind, name, entity, head, 0])
            head = ""
        elif token == "}" and scopes:
            kind, name, entity, before, parens = scopes.pop()
            if entity:
                entity.last = line
            head = before + "{}" if kind in ("init", "nested") else ""
        elif token == ";" and not inside:
            statement()
            head = ""
        elif not (scopes and scopes[-1][0] in ("block", "nested")):
            if not head.strip():
                head_line = line
            head += token
        if token == ":" and re.match(r"\s*(public|private|protected)\s*:$", head):
            head = ""
    return found


def lost(path, text=None):
    """Lines that open a definition of a namespace (they stand in the first column) and that scan() did not take for one."""
    text = read(path) if text is None else text
    known = {line for e in scan(path, text) for line in range(e.line, e.last + 1)}
    for number, line in enumerate(bare(text).split("\n"), 1):
        if re.match(r"[A-Za-z~].*\)[ \w]*\{$", line) and not re.search(r"=.*\{$|\boperator\b", line) and number not in known:
            yield number


def scan_all(*folders):
    return [entity for path in files(*folders) for entity in scan(path)]


def count_controls(rows):
    """(passed, failed) of made-up inputs, each (name, is broken, what the check found); prints what went wrong."""
    wrong = [(name, found) for name, broken, found in rows if bool(found) != broken]
    for name, found in wrong:
        print("control: %s: %s" % (name, found or "not found"))
    return len(rows) - len(wrong), len(wrong)
