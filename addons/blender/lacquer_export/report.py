"""What the exporter has to say: warnings, each once and in one line, and the errors that end it."""


class ExportError(Exception):
    """The scene cannot be exported: the scene file was not written."""


class ExportFileError(ExportError):
    """Because a file cannot be read or written."""


class Report:
    """Collects warnings; `listener` is called with each new one."""

    def __init__(self, listener=None):
        self.warnings = []
        self.listener = listener

    def warn(self, where, message):
        """`where` names the object, material, light or node, `message` says what was taken instead."""
        text = " ".join(f"{where}: {message}".split())
        if text not in self.warnings:
            self.warnings.append(text)
            if self.listener:
                self.listener(text)


def where_of(owner, node=None):
    """The name of a data-block, and of one of its nodes, as warnings have them."""
    text = f"{owner.bl_rna.name.lower()} \"{owner.name}\""
    return text if node is None else f"{text}, node \"{node.name}\" ({node.bl_idname})"
