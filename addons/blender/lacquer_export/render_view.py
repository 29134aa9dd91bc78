"""What a render would see, in the depsgraph of the viewport: Python has no other one outside of render engines."""
from contextlib import contextmanager


def rendered_objects(view_layer):
    """Names of the objects that a render shows: in collections that are neither excluded nor disabled in renders."""
    found = set()

    def visit(layer, collection_visible):
        visible = collection_visible and not layer.exclude and not layer.collection.hide_render
        if visible:
            found.update(o for o in layer.collection.objects if not o.hide_render)
        for child in layer.children:
            visit(child, visible)

    visit(view_layer.layer_collection, True)
    return found


@contextmanager
def render_settings(context):
    """For a while, modifiers and visibility of the viewport are those of renders; afterwards everything is as before."""
    changed = []

    def change(owner, name, value):
        before = getattr(owner, name)
        if before != value:
            try:
                setattr(owner, name, value)
            except AttributeError:  # linked data cannot be changed
                return
            changed.append((owner, name, before))

    hidden = []
    objects = rendered_objects(context.view_layer)
    try:
        for layer in layers(context.view_layer.layer_collection):
            change(layer, "hide_viewport", False)
            change(layer.collection, "hide_viewport", False)
        for owner in objects:
            change(owner, "hide_viewport", False)
            if owner.name in context.view_layer.objects and owner.hide_get(view_layer=context.view_layer):
                hidden.append(owner)
                owner.hide_set(False, view_layer=context.view_layer)
        for owner in context.scene.objects:
            for modifier in owner.modifiers:
                change(modifier, "show_viewport", modifier.show_render)
                if modifier.type in ("SUBSURF", "MULTIRES"):
                    change(modifier, "levels", modifier.render_levels)
        context.view_layer.update()
        yield objects
    finally:
        for owner, name, before in reversed(changed):
            setattr(owner, name, before)
        for owner in hidden:
            owner.hide_set(True, view_layer=context.view_layer)


def layers(layer):
    yield layer
    for child in layer.children:
        yield from layers(child)
