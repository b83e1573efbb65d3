"""Documents of SPDX 2.3 as JSON: packages, their relations, licences that have no number; and a check of their structure."""
import datetime
import hashlib
import json
import re

ID = re.compile(r"SPDXRef-[A-Za-z0-9.-]+")
CREATED = "%Y-%m-%dT%H:%M:%SZ"
RELATIONS = {"DESCRIBES", "CONTAINS", "STATIC_LINK", "DYNAMIC_LINK", "OPTIONAL_DEPENDENCY_OF", "GENERATED_FROM"}
TERM = r"\(*(?:LicenseRef-[A-Za-z0-9.-]+|[A-Za-z0-9.+-]+)\)*"
EXPRESSION = re.compile(rf"{TERM}(?: (?:AND|OR|WITH) {TERM})*")


def identifier(*words):
    return "SPDXRef-" + re.sub(r"[^A-Za-z0-9.]+", "-", "-".join(words).replace("+", "plus")).strip("-")


class Document:
    def __init__(self, name, namespace, epoch_s, tool):
        """namespace: a URI, to which a digest of what the document says is added: documents that differ must not share one."""
        created = datetime.datetime.fromtimestamp(epoch_s, datetime.timezone.utc).strftime(CREATED)
        self._packages, self._relations, self._texts = {}, set(), {}
        self._head = {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": name,
                      "documentNamespace": namespace, "creationInfo": {"created": created, "creators": [f"Tool: {tool}"]}}

    def package(self, key, name, version, licence, texts=(), **more):
        """Adds a package once; more: fields of SPDX. Returns its identifier."""
        self._packages.setdefault(key, {"SPDXID": key, "name": name, "versionInfo": version, "downloadLocation": "NOASSERTION",
                                        "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence,
                                        "copyrightText": "NOASSERTION", **more})
        self._texts.update(texts)
        return key

    def relate(self, element, relation, related):
        self._relations.add((element, relation, related))

    def json(self):
        said = {**self._head, "packages": [self._packages[key] for key in sorted(self._packages)],
                "hasExtractedLicensingInfos": [{"licenseId": key, "extractedText": text} for key, text in sorted(self._texts.items())],
                "relationships": [{"spdxElementId": a, "relationshipType": relation, "relatedSpdxElement": b}
                                  for a, relation, b in sorted(self._relations)]}
        digest = hashlib.sha256(json.dumps(said, sort_keys=True).encode()).hexdigest()[:32]
        return {**said, "documentNamespace": f"{said['documentNamespace']}-{digest}"}


def faults(document):
    """What is wrong with the structure of a document, one sentence each."""
    for field, value in (("spdxVersion", "SPDX-2.3"), ("dataLicense", "CC0-1.0"), ("SPDXID", "SPDXRef-DOCUMENT")):
        if document.get(field) != value:
            yield f"{field} is {document.get(field)!r} instead of {value!r}"
    for field in ("name", "documentNamespace"):
        if not document.get(field):
            yield f"{field} is missing"
    if not re.fullmatch(r"[a-z]+://[^#\s]+", document.get("documentNamespace", "")):
        yield "documentNamespace is no URI without a fragment"
    yield from _creation_faults(document.get("creationInfo", {}))
    texts = {info.get("licenseId") for info in document.get("hasExtractedLicensingInfos", []) if info.get("extractedText")}
    known = {"SPDXRef-DOCUMENT"}
    for package in document.get("packages", []):
        key = package.get("SPDXID", "")
        if not ID.fullmatch(key) or key in known:
            yield f"package {package.get('name')!r}: identifier {key!r} is malformed or not unique"
        known.add(key)
        yield from _package_faults(package, texts)
    described = False
    for relation in document.get("relationships", []):
        kind = relation.get("relationshipType")
        described |= kind == "DESCRIBES"
        if kind not in RELATIONS:
            yield f"relationship {kind!r} is unknown"
        yield from (f"{kind}: {relation.get(end)!r} is no element" for end in ("spdxElementId", "relatedSpdxElement")
                    if relation.get(end) not in known)
    if not described:
        yield "the document describes nothing"


def _creation_faults(info):
    try:
        datetime.datetime.strptime(info.get("created", ""), CREATED)
    except ValueError:
        yield f"creationInfo.created is {info.get('created')!r}"
    if not info.get("creators") or not all(re.match(r"(Tool|Person|Organization): \S", who) for who in info["creators"]):
        yield f"creationInfo.creators is {info.get('creators')!r}"


def _package_faults(package, texts):
    name = package.get("name") or package.get("SPDXID")
    for field in ("name", "versionInfo", "downloadLocation", "licenseConcluded", "licenseDeclared", "copyrightText"):
        if not package.get(field):
            yield f"package {name!r}: {field} is missing"
    licence = package.get("licenseDeclared", "")
    if not EXPRESSION.fullmatch(licence) or licence.count("(") != licence.count(")"):
        yield f"package {name!r}: {licence!r} is no licence expression"
    for reference in re.findall(r"LicenseRef-[A-Za-z0-9.-]+", licence):
        if reference not in texts:
            yield f"package {name!r}: {reference} has no text"
    for checksum in package.get("checksums", []):
        if checksum.get("algorithm") != "SHA256" or not re.fullmatch(r"[0-9a-f]{64}", checksum.get("checksumValue", "")):
            yield f"package {name!r}: malformed checksum {checksum}"
