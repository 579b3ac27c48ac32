renderMathInElement(document.body, {
    delimiters: [
        { left: "\\(", right: "\\)", display: false },
        { left: "\\[", right: "\\]", display: true },
    ],
    throwOnError: false,
});
