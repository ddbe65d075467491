"""The side bar as a person uses it: look for a button or a field, click it, type into it. Blender does not tell where
its buttons are: the mouse goes over the side bar, and Blender is asked what is under it."""

import bpy
from events import area, click, event, in_view, pause, press, region, template, type_text, until

# Without a template the inner ones are not there.
_OUTER = ("Template", "Scan", "Skeleton", "Separate")
_ALL = ("Template", "Scan", "Markers", "Landmarks", "Attachments", "Carried", "Reshape", "Result", "Skeleton", "Separate")
# Pixels: how far headers of closed panels are apart, and the first from the top; how high a row is at least.
_HEADER, _FIRST, _ROW = 28, 15, 16
# Where to look along a row, as shares of its width: most things reach to the right half.
_ACROSS, LEFT, ICON = (0.7,), (0.25,), (0.86,)
_TABS = 20

# What was found at each place that was looked at, the latest last.
_texts = {}


def open_tab():
    """Opens the side bar, and in it the fourth tab, below Item, Tool and View."""
    area().spaces.active.show_region_ui = True
    yield from until(lambda: region("UI").width > 100, "the side bar")
    for _ in range(5):
        yield from pause()
        side = region("UI")
        yield from show_panels("Template")
        text = yield from _text_at(side.x + side.width // 3, side.y + side.height - 45)
        if "moulage" in text:
            return
        yield from click(side.x + side.width - 12, side.y + side.height - 167)
    raise AssertionError("the tab Moulage does not open")


def show_panels(*names):
    """Opens these panels and closes all others."""
    side = region("UI")
    x, top = side.x + 55, side.y + side.height - _FIRST
    yield from _scroll("WHEELUPMOUSE", 60)
    # Ctrl closes the others.
    yield from click(x, top, ctrl=True)
    yield from pause()
    yield from click(x, top)
    yield from pause()
    # The lowest first: the headers above it stay where they are.
    there = _OUTER if template() is None else _ALL
    for number in sorted((there.index(name) for name in names), reverse=True):
        yield from click(x, top - _HEADER * number)
        yield from pause()
    _texts.clear()


def _scroll(wheel, count):
    side = region("UI")
    for _ in range(count):
        # Below the last panel the wheel would zoom the view.
        event(wheel, "PRESS", (side.x + side.width // 2, side.y + side.height - _FIRST))
    yield from pause()


def scroll_to_end():
    yield from _scroll("WHEELDOWNMOUSE", 60)
    _texts.clear()


def _text_at(x, y):
    """The data path or the command of the button there, or nothing."""
    event("MOUSEMOVE", "NOTHING", (x, y))
    yield
    yield
    with in_view("UI"):
        manager = bpy.context.window_manager
        for ask in (lambda: bpy.ops.ui.copy_data_path_button(full_path=True), bpy.ops.ui.copy_python_command_button):
            manager.clipboard = ""
            try:
                ask()
            except RuntimeError:
                # There is no button, or none of this kind.
                continue
            if manager.clipboard:
                return manager.clipboard
    return ""


def find(wanted, across=_ACROSS):
    """Where the button is whose command or data path has the text; where it was seen last is looked at first."""
    # The layout may be about to change.
    yield from pause()
    for scroll in (None, "WHEELUPMOUSE", *["WHEELDOWNMOUSE"] * 4):
        if scroll is not None:
            yield from _scroll(scroll, 60 if scroll == "WHEELUPMOUSE" else 12)
            _texts.clear()
        for x, y in _places(wanted, across):
            text = yield from _text_at(x, y)
            _texts.pop((x, y), None)
            _texts[x, y] = text
            if _is(wanted, text):
                return x, y
    raise AssertionError(f"no button or field {wanted} in the side bar")


def _is(wanted, text):
    """A property is told by the end of its path, a button by a part of its command."""
    return text.endswith(wanted) if wanted.startswith(".") else wanted in text


def _places(wanted, across):
    side = region("UI")
    rows = range(side.y + side.height - 8, side.y + 8, -_ROW)
    places = [(side.x + int(share * (side.width - _TABS)), y) for y in rows for share in across]
    before = next((place for place, text in reversed(_texts.items()) if _is(wanted, text)), None)
    if before is not None:
        places.sort(key=lambda p: abs(p[1] - before[1]) + (p[0] != before[0]))
        places.insert(0, before)
    else:
        # Another button was there a moment ago.
        places.sort(key=lambda p: p in _texts)
    return places


def click_button(wanted, across=_ACROSS, **modifiers):
    x, y = yield from find(wanted, across)
    yield from click(x, y, **modifiers)


def type_into(wanted, text, across=_ACROSS):
    """Over the field Enter, which selects what is there; the text, Enter."""
    place = yield from find(wanted, across)
    press("RET", place)
    yield from pause()
    yield from type_text(text)
    press("RET")
    yield from pause()


def write_into(wanted, text, across=_ACROSS):
    """The same for a field with a path, which takes no Enter: a click, the text, Enter."""
    yield from click_button(wanted, across)
    yield from pause()
    yield from type_text(text)
    press("RET")
    yield from pause()


def choose(wanted, letter, across=_ACROSS):
    """Opens a menu and chooses the entry with the underlined letter."""
    place = yield from find(wanted, across)
    yield from choose_at(place, letter)


def choose_at(place, letter):
    yield from click(*place)
    yield from pause()
    # Away from the menu the mouse would close it.
    press(letter, place)
    yield from pause()


def pick(wanted, name, across=_ACROSS):
    """Picks an object or collection: click the field, type the name, Enter."""
    yield from click_button(wanted, across)
    yield from pause()
    yield from type_text(name)
    yield from pause()
    press("RET")
    yield from pause()


def empty_field(wanted, across=_ACROSS):
    """Over the field Backspace: back to what it was at first."""
    place = yield from find(wanted, across)
    press("BACK_SPACE", place)
    yield from pause()


def open_inner_panel(below, shows, gap):
    """Opens the panel inside another one whose header is so far below the lower edge of a button."""
    x, y = yield from find(below)
    while _is(below, (yield from _text_at(x, y))):
        y -= 3
    yield from click(x, y - gap)
    yield from pause()
    yield from find(shows)
