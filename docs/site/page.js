renderMathInElement(document.body, {
    delimiters: [
        { left: "\\(", right: "\\)", display: false },
        { left: "\\[", right: "\\]", display: true },
    ],
    throwOnError: false,
});

// Long names in tables may go on in a new line, after an underscore or a colon and nowhere else.
for (const code of document.querySelectorAll("td code")) {
    for (const node of [...code.childNodes].filter((n) => n.nodeType === Node.TEXT_NODE)) {
        const parts = node.textContent.split(/(?<=\w[_:.])(?=\w{2})/);
        node.replaceWith(...parts.flatMap((part, i) => (i ? [document.createElement("wbr"), part] : [part])));
    }
}
