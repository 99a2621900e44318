// Short words for what every script of a page does.
const every = (inside, selector) => [...inside.querySelectorAll(selector)];
const one = (inside, selector) => inside.querySelector(selector);
const listen = (element, name, does, options) => element.addEventListener(name, does, options);
