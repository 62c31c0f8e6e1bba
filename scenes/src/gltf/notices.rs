//! What the importer tells the user: one sentence per kind of thing, with how many there are.

/// Sentences in the order in which they first came up.
#[derive(Default)]
pub(super) struct Notices {
    entries: Vec<(String, usize)>,
}

impl Notices {
    /// Notes something about the file as a whole, once.
    pub(super) fn say(&mut self, sentence: impl Into<String>) {
        self.entries.push((sentence.into(), 0));
    }

    /// Notes that `sentence`, about things of one kind, holds for `count` more of them.
    pub(super) fn count(&mut self, sentence: &'static str, count: usize) {
        match self.entries.iter_mut().find(|(known, _)| known == sentence) {
            Some((_, total)) => *total += count,
            None if count > 0 => self.entries.push((sentence.into(), count)),
            None => {}
        }
    }

    /// The sentences, each with its count if it has one.
    pub(super) fn into_sentences(self) -> Vec<String> {
        let with_count = |(sentence, count): (String, usize)| match count {
            0 => sentence,
            _ => format!("{sentence} ({count})"),
        };
        self.entries.into_iter().map(with_count).collect()
    }
}
