"""XML of strangers: a text becomes elements with their lines, unless it declares entities or goes beyond a limit."""

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from plumbline.harness.intake.allowance import allowance, beyond
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted, readable


@dataclass(slots=True, eq=False)
class Element:
    """An element of an XML text. Terms: line: where it begins. file: which text it stands in, in words."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: "list[Element]" = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> "list[Element]":
        """The children of a tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> "Element | None":
        """The first child of a tag, or None."""
        for child in self.children:
            if child.tag == tag:
                return child
        return None

    def walk(self) -> "Iterator[Element]":
        """The element itself and all below it, in the order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting += reversed(element.children)

    @property
    def where(self) -> str:
        """File, line, tag and name, in words."""
        name = self.attributes.get("name")
        return f"{self.file}: line {self.line}: <{quoted(self.tag, 60)[1:-1]}>{'' if name is None else ' ' + quoted(name, 80)}"

    def refuse(self, reason: str) -> RobotError:
        """The error that this element is."""
        return RobotError(f"{self.where}: {reason}")


def elements(text: str, file: str) -> Element:
    """The root of an XML text, which `file` names in words.

    Raises:
        RobotError: where it is not well-formed, has a DOCTYPE or an entity, or is deeper or fuller than is allowed.
    """
    from xml.sax import SAXParseException
    from xml.sax.handler import ContentHandler
    from xml.sax.xmlreader import InputSource

    from defusedxml.common import DefusedXmlException, DTDForbidden
    from defusedxml.sax import make_parser

    class Reader(ContentHandler):
        """Builds the elements, and stops where there are too many."""

        def __init__(self) -> None:
            super().__init__()
            self.open: list[Element] = []
            self.root: Element | None = None
            self.count = 0
            self.locator: Any = None
            self.values: dict[str, str] = {}

        def setDocumentLocator(self, locator: Any) -> None:
            self.locator = locator

        def startElement(self, name: str, attrs: Any) -> None:
            # Most values stand in many elements: each text is kept once.
            attributes = {word: self.values.setdefault(value, value) for word, value in attrs.items()}
            element = Element(name, attributes, file, self.locator.getLineNumber())
            self.count += 1
            if self.count > allowed.parts or len(self.open) >= allowed.depth:
                parts = beyond("parts", self.count, "elements")
                raise element.refuse(parts or beyond("depth", len(self.open) + 1, "elements in each other"))
            if self.open:
                self.open[-1].children.append(element)
            else:
                self.root = element
            self.open.append(element)

        def endElement(self, name: str) -> None:  # noqa: ARG002  # the parser has checked that it is the open one
            self.open.pop()

        def characters(self, content: str) -> None:
            if self.open:
                self.open[-1].text += content

    allowed = allowance()
    reader, parser, source = Reader(), make_parser(), InputSource()
    parser.forbid_dtd = True
    parser.setContentHandler(reader)
    source.setEncoding("utf-8")
    try:
        source.setByteStream(io.BytesIO(text.encode()))
        parser.parse(source)
    except DTDForbidden as error:
        raise RobotError(
            f"{file}: <!DOCTYPE> {quoted(error.name, 80)}: a document type can define entities; expected none"
        ) from None
    except DefusedXmlException as error:
        raise RobotError(f"{file}: {readable(str(error), 300)}; expected no entities and no references") from None
    except SAXParseException as error:
        raise RobotError(
            f"{file}: line {error.getLineNumber()}: no well-formed XML: {readable(error.getMessage(), 200)}"
        ) from None
    except ValueError as error:
        if isinstance(error, RobotError):
            raise
        raise RobotError(f"{file}: no well-formed XML: {readable(str(error), 200)}") from None
    if reader.root is None:
        raise RobotError(f"{file}: no element, expected one")
    return reader.root
