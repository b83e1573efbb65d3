"""Test of fire3dv.show: the frame of a live view in a notebook, and what is not a link."""
from html.parser import HTMLParser

import fire3dv

TOKEN = "0123456789abcdef" * 2


class Frames(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


for address in ("http://127.0.0.1:8080/", "https://[::1]:9/", "http://localhost:80/"):
    view = fire3dv.show(address + "#" + TOKEN, height=300)
    [(tag, attributes)] = Frames(view._repr_html_()).found
    assert tag == "iframe" and attributes["src"] == f"{address}?embed=1#{TOKEN}" and attributes["height"] == "300", attributes
    assert TOKEN not in repr(view) and TOKEN not in str(view), view

# Behind a proxy the page has a path.
for path in ("/user/me/proxy/8080/", "/user/me/proxy/8080", "/a%20b/"):
    [(tag, attributes)] = Frames(fire3dv.show(f"https://hub{path}#{TOKEN}")._repr_html_()).found
    assert attributes["src"] == f"https://hub{path}?embed=1#{TOKEN}", attributes

STATE = "&view=1,-2.5,3,0,0,0,1,2,0.8&node=arm%2Flink%201"
[(tag, attributes)] = Frames(fire3dv.show(f"http://127.0.0.1:8080/?embed=1#{TOKEN}{STATE}")._repr_html_()).found
assert attributes["src"] == f"http://127.0.0.1:8080/?embed=1#{TOKEN}{STATE}", attributes

for link in ("", "127.0.0.1:8080", f"ftp://host/#{TOKEN}", "http://127.0.0.1:8080/", f"http:///#{TOKEN}",
             f"http://host/#{TOKEN}0", f"http://host/#{TOKEN}&other=1", f'http://host/#{TOKEN}&node="',
             "javascript:alert(1)#" + TOKEN,
             "http://[::1#" + TOKEN, 5, None, b"http://host/"):
    try:
        fire3dv.show(link)
    except fire3dv.ArgumentError as error:
        assert "--serve" in str(error), error
        assert "serve=True" in str(error), error
    else:
        raise AssertionError(f"show({link!r}) raised nothing")
for height in (0, 1.5, "300"):
    try:
        fire3dv.show("http://127.0.0.1:1/#" + TOKEN, height)
    except fire3dv.ArgumentError:
        continue
    raise AssertionError(f"a height of {height!r} raised nothing")
# A host that would end the attribute stays inside it.
[(tag, attributes)] = Frames(fire3dv.show(f'http://a/"onload="x/#{TOKEN}')._repr_html_()).found
assert set(attributes) == {"src", "width", "height", "style", "referrerpolicy"}, attributes
[(tag, attributes)] = Frames(fire3dv.show(f'http://a"onload="x/#{TOKEN}')._repr_html_()).found
assert set(attributes) == {"src", "width", "height", "style", "referrerpolicy"}, attributes
print("passed")
