//! Answers and refusals of the server.

use serde::Serialize;

use crate::campaign::file::CampaignErrors;
use crate::campaign::{AdoptError, Error};
use crate::finding::Finding;

/// An answer to a request.
#[derive(Debug)]
pub(super) struct Answer {
    /// HTTP status.
    pub status: u16,
    /// Media type.
    pub media: &'static str,
    /// Content.
    pub body: Vec<u8>,
    /// Content security policy: what the browser may load.
    pub policy: String,
}

impl Answer {
    /// A result as JSON.
    pub fn json(result: &impl Serialize) -> Answer {
        Answer::with_status(200, result)
    }

    /// An HTML page with its own content security policy.
    pub fn page(html: String, policy: String) -> Answer {
        Answer { status: 200, media: "text/html; charset=utf-8", body: html.into_bytes(), policy }
    }

    fn with_status(status: u16, result: &impl Serialize) -> Answer {
        let (status, body) = match serde_json::to_vec(result) {
            Ok(body) => (status, body),
            Err(_) => (500, br#"{"message":"the result cannot be written as JSON"}"#.to_vec()),
        };
        Answer { status, media: "application/json", body, policy: "default-src 'none'".into() }
    }
}

/// A refused request.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Refusal {
    #[serde(skip)]
    pub status: u16,
    /// What is wrong and what to do.
    pub message: String,
    /// Findings with the reasons, as on the command line.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub findings: Vec<Finding>,
}

impl Refusal {
    fn new(status: u16, message: impl Into<String>) -> Refusal {
        Refusal { status, message: message.into(), findings: Vec::new() }
    }

    /// The request is wrong.
    pub fn bad(message: impl Into<String>) -> Refusal {
        Refusal::new(400, message)
    }

    /// The request is not allowed.
    pub fn forbidden(message: impl Into<String>) -> Refusal {
        Refusal::new(403, message)
    }

    /// The requested object does not exist.
    pub fn absent(message: impl Into<String>) -> Refusal {
        Refusal::new(404, message)
    }

    /// The request conflicts with the current state.
    pub fn conflict(message: impl Into<String>) -> Refusal {
        Refusal::new(409, message)
    }

    /// The request exceeds the maximum size.
    pub fn too_large(message: impl Into<String>) -> Refusal {
        Refusal::new(413, message)
    }

    /// The campaign or its data was refused.
    pub fn unusable(message: impl Into<String>) -> Refusal {
        Refusal::new(422, message)
    }

    /// The server failed.
    pub fn failed(message: impl Into<String>) -> Refusal {
        Refusal::new(500, message)
    }

    pub fn answer(&self) -> Answer {
        Answer::with_status(self.status, self)
    }
}

impl From<Error> for Refusal {
    fn from(error: Error) -> Refusal {
        Refusal { findings: error.findings().to_vec(), ..Refusal::unusable(error.to_string()) }
    }
}

impl From<CampaignErrors> for Refusal {
    fn from(errors: CampaignErrors) -> Refusal {
        Refusal::unusable(errors.to_string())
    }
}

impl From<AdoptError> for Refusal {
    fn from(error: AdoptError) -> Refusal {
        Refusal::unusable(error.to_string())
    }
}

impl From<crate::report_content::Unhashed> for Refusal {
    fn from(error: crate::report_content::Unhashed) -> Refusal {
        Refusal::failed(error.to_string())
    }
}
