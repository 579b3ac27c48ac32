// Search in pages that were opened from a disk, without a server. Browsers then let a page neither fetch the index nor
// start a worker: the index comes as a script, and a hidden frame does the worker's part.
if (location.protocol === "file:") {
    const index = document.currentScript.dataset.index;
    document.write(`<script src="${index}"></` + "script>");

    window.Worker = class extends EventTarget {
        constructor(address) {
            super();
            const frame = document.createElement("iframe");
            frame.hidden = true;
            document.body.append(frame);
            const scope = frame.contentWindow;
            scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
            this.ready = new Promise((resolve) => {
                const script = frame.contentDocument.createElement("script");
                script.onload = () => resolve(scope);
                script.src = new URL(address, location);
                frame.contentDocument.body.append(script);
            });
        }
        postMessage(data) {
            this.ready.then((scope) => scope.dispatchEvent(new scope.MessageEvent("message", { data })));
        }
    };
}
